// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Bundles the script and the style of a page with their libraries.
import { build } from "esbuild";
import { readFileSync, writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";

const modules = fileURLToPath(new URL("node_modules", import.meta.url));

function licenceOf(name) {
  const { version } = JSON.parse(readFileSync(`${modules}/${name}/package.json`, "utf8"));
  return `${name} ${version}\n\n${readFileSync(`${modules}/${name}/LICENSE`, "utf8").trim()}\n`;
}

// Writes dist/NAME.js, dist/NAME.css and dist/licences.txt of `folder` from its src/main.js and src/style.css.
export async function bundle({ folder, name, libraries }) {
  const licences = libraries.map(licenceOf).join("\n----\n\n");
  writeFileSync(`${folder}/dist/licences.txt`, licences);
  await build({
    absWorkingDir: folder,
    entryPoints: { [name]: "src/main.js" },
    bundle: true,
    minify: true,
    format: "iife",
    target: ["chrome100", "firefox100", "safari15"],
    charset: "ascii",
    legalComments: "none",
    // The page carries the libraries away with it, so their licences go along.
    banner: { js: `/*! This page holds parts of:\n\n${licences}*/` },
    nodePaths: [modules],
    outdir: "dist",
  });
  await build({ absWorkingDir: folder, entryPoints: { [name]: "src/style.css" }, bundle: true, minify: true, charset: "utf8", nodePaths: [modules], outdir: "dist" });
}
