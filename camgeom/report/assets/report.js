// One cam angle for the whole page: a cursor in every plot over the cam angle follows the pointer and the 3D view.
(() => {
  const cursors = [...document.querySelectorAll("[data-cam]")].map((path) => {
    const [x0, x1, low, high, ...heights] = path.dataset.cam.split(" ").map(Number);
    return { path, svg: path.ownerSVGElement, x0, x1, low, high, heights };
  });
  const spans = (heights, x) => {
    let d = "";
    for (let i = 0; i < heights.length; i += 2) d += `M${x} ${heights[i]}V${heights[i + 1]}`;
    return d;
  };
  const move = (angle) => {
    for (const c of cursors) {
      const inside = angle >= c.low && angle <= c.high;
      const x = c.x0 + ((angle - c.low) / (c.high - c.low)) * (c.x1 - c.x0);
      c.path.setAttribute("d", inside ? spans(c.heights, x.toFixed(1)) : "");
    }
  };
  document.addEventListener("camangle", (event) => move(event.detail.angle));
  for (const c of cursors) {
    c.svg.addEventListener("pointermove", (event) => {
      const box = c.svg.getBoundingClientRect();
      const x = ((event.clientX - box.left) / box.width) * c.svg.viewBox.baseVal.width;
      if (x < c.x0 || x > c.x1) return;
      const angle = c.low + ((x - c.x0) / (c.x1 - c.x0)) * (c.high - c.low);
      document.dispatchEvent(new CustomEvent("camangle", { detail: { angle, from: c } }));
    });
  }
})();
