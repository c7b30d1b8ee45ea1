// The controls under the view, built as plain elements; every text is set as text.

export function element(name, attributes = {}, ...children) {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (value !== undefined) node.setAttribute(key, value);
  }
  node.append(...children);
  return node;
}

export function select(label, options, onchange) {
  const box = element("select", { "aria-label": label, onchange: () => onchange(box.value) });
  for (const [value, text] of options) box.append(element("option", { value }, text));
  return { row: element("label", { class: "control" }, element("span", {}, label), box), box };
}

export function slider(label, low, high, step, value, oninput) {
  const box = element("input", { type: "range", min: low, max: high, step, "aria-label": label });
  box.value = value;
  box.addEventListener("input", () => oninput(Number(box.value)));
  return box;
}

export function button(text, title, onclick) {
  return element("button", { type: "button", title, onclick }, text);
}

export function figureText(value) {
  const size = Math.abs(value);
  if (size > 0 && size < 0.1) return value.toPrecision(3).replace("-", "−");
  const digits = size >= 1000 ? 0 : size >= 100 ? 1 : size >= 1 ? 2 : 3;
  return value.toFixed(digits).replace("-", "−");
}

export function legend(shade) {
  const canvas = element("canvas", { width: 256, height: 1, class: "ramp" });
  const context = canvas.getContext("2d");
  const image = context.createImageData(256, 1);
  for (let i = 0; i < 256; i++) {
    for (let c = 0; c < 3; c++) image.data[4 * i + c] = parseInt(shade.scale.slice(6 * i + 2 * c, 6 * i + 2 * c + 2), 16);
    image.data[4 * i + 3] = 255;
  }
  context.putImageData(image, 0, 0);
  const numbers = element("div", { class: "numbers" });
  for (const [at, text] of shade.ticks) {
    const spot = element("span", {}, text);
    spot.style.left = `${100 * at}%`;
    numbers.append(spot);
  }
  const unit = `${shade.factor} ${shade.unit}`.trim();
  const title = unit ? `${shade.label}, ${unit}` : shade.label;
  return element("div", { class: "legend" }, element("div", { class: "name" }, title), canvas, numbers);
}
