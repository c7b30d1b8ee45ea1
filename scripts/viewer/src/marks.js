// What gives a picture its direction and size: the axes of the machine, and a bar of round length.
import { Vector3 } from "three";

const SHAPE = "http://www.w3.org/2000/svg";
const AXES = [["X", new Vector3(1, 0, 0)], ["Y", new Vector3(0, 1, 0)], ["Z", new Vector3(0, 0, 1)]];
const REACH = 24, SIZE = 72, ALONG_VIEW = 0.15;
const LONGEST = 0.25; // of the picture's lower side

export class Marks {
  constructor(stage) {
    this.axes = document.createElementNS(SHAPE, "svg");
    this.axes.setAttribute("class", "axes");
    this.axes.setAttribute("viewBox", `0 0 ${SIZE} ${SIZE}`);
    this.axes.setAttribute("role", "img");
    this.axes.setAttribute("aria-label", "Axes of the machine");
    this.ruler = document.createElement("div");
    this.ruler.className = "ruler";
    stage.append(this.axes, this.ruler);
  }

  // As the camera stands now.
  update(camera, width, height) {
    const right = new Vector3().setFromMatrixColumn(camera.matrixWorld, 0), up = new Vector3().setFromMatrixColumn(camera.matrixWorld, 1);
    const parts = [];
    for (const [name, axis] of AXES) {
      const x = axis.dot(right), y = -axis.dot(up), length = Math.hypot(x, y);
      if (length < ALONG_VIEW) continue; // it points at the eye
      const middle = SIZE / 2, [a, b] = [middle + REACH * x, middle + REACH * y];
      parts.push(`<path class="axis-${name.toLowerCase()}" d="M${middle} ${middle}L${a.toFixed(1)} ${b.toFixed(1)}"/>`);
      parts.push(`<text x="${(a + (8 * x) / length).toFixed(1)}" y="${(b + (8 * y) / length + 4).toFixed(1)}" text-anchor="middle">${name}</text>`);
    }
    this.axes.innerHTML = parts.join("");
    const perPixel = (camera.right - camera.left) / camera.zoom / width; // mm
    const longest = LONGEST * Math.min(width, height) * perPixel;
    const decade = 10 ** Math.floor(Math.log10(longest));
    const round = [5, 2, 1].map((step) => step * decade).find((step) => step <= longest);
    this.ruler.textContent = `${Number(round.toPrecision(1))}\u202fmm`;
    this.ruler.style.width = `${(round / perPixel).toFixed(1)}px`;
  }
}
