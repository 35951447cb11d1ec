// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

import { showBone } from "./bone.js";
import { showPictures } from "./pictures.js";
import { showRun } from "./run.js";

const data = JSON.parse(document.getElementById("run-data").textContent);
const bone = showBone(data.bone, data.tool);
showRun(data.plot, data.pictures, (...moment) => bone?.moveTo(...moment));
showPictures();
