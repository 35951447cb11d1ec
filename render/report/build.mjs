// Bundles src/ with its libraries into dist/, which is committed: npm ci && npm run build.
import { bundle } from "./bundle.mjs";
import { fileURLToPath } from "node:url";

await bundle({ folder: fileURLToPath(new URL(".", import.meta.url)), name: "report", libraries: ["three", "uplot", "fflate"] });
