// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

import { measuredText, numberText, pageData } from "../shared/scene.js";
import { showBone } from "./bone.js";
import { showPictures } from "./pictures.js";
import { showRun } from "./run.js";
import { showSummary } from "./summary.js";

const data = pageData();
showSummary(data.summary);
const bone = showBone(data.bone, data.tool);
showRun(data.plot, data.pictures, (...moment) => bone?.moveTo(...moment));
showPictures();
globalThis.report = { measuredText, numberText };  // for tests
