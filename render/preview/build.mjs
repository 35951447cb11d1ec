// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Bundles src/ into dist/, which is committed. The libraries are those of render/report: (cd ../report && npm ci && npm run build).
import { bundle } from "../report/bundle.mjs";
import { fileURLToPath } from "node:url";

await bundle({ folder: fileURLToPath(new URL(".", import.meta.url)), name: "preview", libraries: ["three", "fflate"] });
