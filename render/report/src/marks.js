// Decorations of the 3D view: directions, scale bar, legends.
import { Vector3 } from "three";

const svg = "http://www.w3.org/2000/svg";

function element(name, attributes, text) {
  const made = document.createElementNS(svg, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

export function drawAxes(place, look, camera) {
  const directions = look.anatomical
    ? [["superior", look.superior], ["lateral", look.outward], ["anterior", look.anterior]]
    : [["tool's axis", look.axis]];
  place.replaceChildren();
  for (const [name, direction] of directions) {
    if (direction === null) continue;
    const eye = new Vector3(...direction).transformDirection(camera.matrixWorldInverse);
    const [x, y] = [34 * eye.x, -34 * eye.y];
    place.append(element("line", { x1: 0, y1: 0, x2: x, y2: y }));
    if (Math.hypot(x, y) < 14) continue;  // viewed end-on: its label would overlap the others
    const away = 1 + 7 / Math.hypot(x, y);
    const anchor = Math.abs(x) < 12 ? "middle" : x > 0 ? "start" : "end";
    const below = Math.abs(x) < 12 ? (y > 0 ? 10 : -2) : 4;
    place.append(element("text", { x: x * away, y: y * away + below, "text-anchor": anchor }, name));
  }
}

export function drawScale(place, mmPerPixel) {
  const most = 120 * mmPerPixel;
  const decade = 10 ** Math.floor(Math.log10(most));
  const length = decade * (most / decade >= 5 ? 5 : most / decade >= 2 ? 2 : 1);
  place.children[0].textContent = `${Number(length.toPrecision(3))} mm`;
  place.children[1].style.width = `${length / mmPerPixel}px`;
}

export function legend(title, colors) {
  const made = document.createElement("div");
  made.className = "legend";
  const rgb = (stop) => `rgb(${stop.map((c) => Math.round(255 * c)).join(" ")})`;
  const bar = Object.assign(document.createElement("div"), { className: "bar" });
  bar.style.background = `linear-gradient(to right, ${colors.stops.map(rgb).join(", ")})`;
  const ticks = Object.assign(document.createElement("div"), { className: "ticks" });
  colors.ticks.forEach((text, i) => {
    const tick = Object.assign(document.createElement("span"), { textContent: text });
    tick.style.left = `${(100 * i * colors.step) / colors.max}%`;
    ticks.append(tick);
  });
  made.append(Object.assign(document.createElement("div"), { textContent: title }), bar, ticks);
  return made;
}
