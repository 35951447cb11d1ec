import { showBone } from "./bone.js";
import { showRun } from "./run.js";

const data = JSON.parse(document.getElementById("run-data").textContent);
showRun(data.plot, data.pictures);
showBone(data.bone);
