// Bundles src/ with its libraries into dist/, which is committed: npm ci && npm run build.
import { build } from "esbuild";
import { copyFileSync, readFileSync, writeFileSync } from "node:fs";

const libraries = ["three", "uplot", "fflate"];

function version(name) {
  return JSON.parse(readFileSync(`node_modules/${name}/package.json`, "utf8")).version;
}

const licences = libraries
  .map((name) => `${name} ${version(name)}\n\n${readFileSync(`node_modules/${name}/LICENSE`, "utf8").trim()}\n`)
  .join("\n----\n\n");
writeFileSync("dist/licences.txt", licences);

// The page carries the libraries away with it, so their licences go along.
const banner = `/*! This page holds parts of:\n\n${licences}*/`;

await build({
  entryPoints: { report: "src/main.js" },
  bundle: true,
  minify: true,
  format: "iife",
  target: ["chrome100", "firefox100", "safari15"],
  charset: "ascii",
  legalComments: "none",
  banner: { js: banner },
  outdir: "dist",
});
await build({ entryPoints: { report: "src/style.css" }, bundle: true, minify: true, charset: "utf8", outdir: "dist" });

// Not part of the page: the rules that tests/browser holds it against.
copyFileSync("node_modules/axe-core/axe.min.js", "../../tests/browser/axe.min.js");
