// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

import { find, measuredText, numberText, pageData, part } from "../shared/scene.js";
import { showBone } from "./bone.js";
import { showRun } from "./run.js";
import { showSummary } from "./summary.js";

// Pictures open at full size, where their text is readable on small screens.

function open(picture) {
  const shown = document.querySelector("#viewer img");
  shown.src = picture.src;
  shown.alt = picture.alt;
  find("viewer-caption").textContent = picture.closest("figure").querySelector("figcaption").textContent;
  find("viewer").showModal();
}

// A button round the picture, so that the keyboard reaches it.
function makeOpenable(picture) {
  const button = part("button", { type: "button", class: "open-picture", title: "Show at full size", onclick: () => open(picture) });
  picture.replaceWith(button);
  button.append(picture);
}

function showPictures() {
  const dialog = find("viewer");
  find("viewer-close").addEventListener("click", () => dialog.close());
  dialog.addEventListener("click", (event) => { if (event.target === dialog) dialog.close(); });
  // The 3D view takes the place of the first picture, which then begins the gallery.
  const still = document.querySelector("#bone-still.print-only");
  if (still !== null) {
    const first = still.cloneNode(true);
    first.removeAttribute("id");
    first.className = "screen-only";
    find("gallery").prepend(first);
  }
  find("pictures-help").hidden = false;
  document.querySelectorAll(".gallery img, .frame img").forEach(makeOpenable);
}

const data = pageData();
showSummary(data.summary);
const bone = showBone(data.bone, data.tool);
showRun(data.plot, data.pictures, (...moment) => bone?.moveTo(...moment));
showPictures();
globalThis.report = { measuredText, numberText };  // for tests
