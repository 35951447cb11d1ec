// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Makes dist/, which is committed: npm ci && npm run build. A page is page.html with body, style and scripts of its folder;
// {{data}} and other names in braces are left for page.cpp. Report and preview share dist/scene.js, which page.cpp puts in.
import { build } from "esbuild";
import { copyFileSync, readFileSync, writeFileSync } from "node:fs";
import { basename } from "node:path";

const pages = {
  report: { kind: "reaming report", libraries: ["uplot"], usesScene: true },
  preview: { kind: "preview", libraries: ["yaml"], usesScene: true },
  study: { kind: "study", libraries: ["fflate"], usesScene: false },
};
const sceneLibraries = ["three", "fflate"];
const options = { bundle: true, minify: true, write: false, target: ["chrome100", "firefox100", "safari15"], legalComments: "none" };

const text = (path) => readFileSync(new URL(path, import.meta.url), "utf8");
const shaders = (path) => text(`node_modules/three/src/renderers/shaders/${path}.glsl.js`);

// A page carries its libraries away with it, so their licences go along.
const licenceOf = (name) => `${name} ${JSON.parse(text(`node_modules/${name}/package.json`)).version}\n\n${text(`node_modules/${name}/LICENSE`).trim()}\n`;
const licencesOf = (libraries) => libraries.map(licenceOf).join("\n----\n\n");

// The parts of three's shaders that a material is made of.
function partsOf(material) {
  const parts = new Set(["colorspace_pars_fragment"]), waiting = [shaders(`ShaderLib/${material}`)];
  while (waiting.length > 0) {
    for (const [, name] of waiting.pop().matchAll(/#include <(\w+)>/g)) {
      if (!parts.has(name)) waiting.push(shaders(`ShaderChunk/${name}`));
      parts.add(name);
    }
  }
  return parts.add(material);
}

// The pages draw with shaders of their own and MeshBasicMaterial. What three's other materials need is left out.
const leanThree = {
  name: "lean three",
  setup({ onLoad, onResolve }) {
    const parts = partsOf("meshbasic");
    onResolve({ filter: /^three$/ }, () => ({ path: new URL("node_modules/three/src/Three.js", import.meta.url).pathname, sideEffects: false }));
    onLoad({ filter: /Shader(Chunk|Lib)\/\w+\.glsl\.js$/ }, ({ path }) =>
      parts.has(basename(path, ".glsl.js")) ? undefined : { contents: "export default ''; export const vertex = '', fragment = '';" });
  },
};
// The scripts of a page find what dist/scene.js exports in a global variable.
const sharedScene = {
  name: "shared scene",
  setup({ onLoad, onResolve }) {
    onResolve({ filter: /shared\/scene\.js$/ }, () => ({ path: "scene", namespace: "shared" }));
    onLoad({ filter: /./, namespace: "shared" }, () => ({ contents: "module.exports = sharedScene;" }));
  },
};

async function script(entry, libraries, more) {
  const { outputFiles } = await build({
    ...options, entryPoints: [entry], format: "iife", charset: "ascii", banner: { js: `/*! This page holds parts of:\n\n${licencesOf(libraries)}*/` }, ...more,
  });
  return outputFiles[0].text;
}

async function pageOf(name, { kind, libraries, usesScene }) {
  const style = await build({ ...options, entryPoints: [`${name}/style.css`], charset: "utf8" });
  const scripts = [...(usesScene ? ["{{scene}}"] : []), await script(`${name}/main.js`, libraries, { plugins: usesScene ? [sharedScene] : [] })];
  const parts = {
    kind, style: style.outputFiles[0].text.trim(), body: text(`${name}/page.html`).trim(),
    scripts: scripts.map((each) => `<script>\n${each.trim()}\n</script>`).join("\n"),
  };
  const page = text("page.html").replace(/\{\{(\w+)\}\}/g, (whole, part) => parts[part] ?? whole);
  writeFileSync(`dist/${name}.html`, page);
}

writeFileSync("dist/licences.txt", licencesOf(["three", "fflate", "uplot", "yaml"]));
writeFileSync("dist/scene.js", await script("shared/scene.js", sceneLibraries, { globalName: "sharedScene", plugins: [leanThree] }));
for (const [name, page] of Object.entries(pages)) await pageOf(name, page);

// Not part of a page: the rules that tests/browser holds it against.
copyFileSync("node_modules/axe-core/axe.min.js", "../../tests/browser/axe.min.js");
