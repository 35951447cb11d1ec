// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Bundles src/ with its libraries into dist/, which is committed: npm ci && npm run build.
import { bundle } from "./bundle.mjs";
import { copyFileSync } from "node:fs";
import { fileURLToPath } from "node:url";

await bundle({ folder: fileURLToPath(new URL(".", import.meta.url)), name: "report", libraries: ["three", "uplot", "fflate"] });

// Not part of the page: the rules that tests/browser holds it against.
copyFileSync("node_modules/axe-core/axe.min.js", "../../tests/browser/axe.min.js");
