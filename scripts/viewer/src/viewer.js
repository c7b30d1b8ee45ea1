// The 3D view of a report: bodies that move over the cam angle, a colour per result, a section plane, a probe.
import {
  AmbientLight, Box3, Color, DataTexture, DirectionalLight, Group, LineBasicMaterial, LineSegments, LinearFilter, Mesh,
  MeshStandardMaterial, OrthographicCamera, Quaternion, Raycaster, RGBAFormat, Scene, SRGBColorSpace, Vector2, Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { button, element, figureText, legend, select, slider } from "./controls.js";
import { Marks } from "./marks.js";
import { Section } from "./section.js";
import { displayGeometry, paint } from "./surface.js";
import { unpackScene } from "./unpack.js";

const VIEWS = { Iso: [1, -1.2, 0.8], Front: [0, -1, 0], Side: [1, 0, 0], Top: [0, -0.001, 1] };
const SECONDS_PER_TURN = 10;

class Viewer {
  constructor(figure, data) {
    Object.assign(this, { figure, data, angle: data.angles[0], playing: false, shade: null, hold: false, queued: false });
    this.stage = figure.querySelector(".stage");
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true, stencil: true, preserveDrawingBuffer: true });
    this.renderer.localClippingEnabled = true;
    this.stage.replaceChildren(this.renderer.domElement);
    this.scene = new Scene();
    this.world = new Group();
    this.scene.add(this.world, new AmbientLight(0xffffff, 1.1));
    this.camera = new OrthographicCamera();
    this.camera.up.set(0, 0, 1);
    for (const [x, y, z, power] of [[-0.6, 0.9, 1, 2.2], [1, 0.2, 0.4, 0.7]]) {
      const light = new DirectionalLight(0xffffff, power);
      light.position.set(x, y, z);
      this.camera.add(light);
    }
    this.scene.add(this.camera);
    this.build();
    this.orbit = new OrbitControls(this.camera, this.renderer.domElement);
    this.orbit.addEventListener("change", () => this.ask());
    this.orbit.enableZoom = false; // until the view is touched, so that scrolling the page passes over it
    this.renderer.domElement.addEventListener("pointerdown", () => (this.orbit.enableZoom = true));
    this.renderer.domElement.addEventListener("pointerleave", () => { this.orbit.enableZoom = false; this.tip.hidden = true; });
    this.renderer.domElement.addEventListener("pointermove", (event) => this.probe(event));
    this.panel();
    this.look("Iso");
    this.theme();
    this.turn(this.angle);
    new ResizeObserver(() => this.resize()).observe(this.stage);
    new IntersectionObserver(([entry]) => { this.seen = entry.isIntersecting; if (this.seen) this.ask(); }).observe(this.stage);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.theme());
    document.addEventListener("camangle", (event) => { if (event.detail.from !== this) this.turn(event.detail.angle, true); });
    addEventListener("beforeprint", () => { this.play(false); this.theme(true); this.render(); });
    addEventListener("afterprint", () => this.theme());
  }

  // Other bodies in the same view: camera, angle, section and wanted colour stay; the latest call wins.
  async show(packed) {
    const call = (this.calls = (this.calls ?? 0) + 1);
    const data = await unpackScene(packed);
    if (call !== this.calls) return;
    const { radius, centre } = this;
    for (const body of this.bodies) {
      for (const part of [body.mesh, body.lines]) { part.geometry.dispose(); part.material.map?.dispose(); part.material.dispose(); }
      for (const { material } of body.node.children) material.dispose();
    }
    for (const { cap } of this.section.caps) { this.scene.remove(cap); cap.geometry.dispose(); cap.material.dispose(); }
    this.world.clear();
    this.data = data;
    this.build();
    if (this.radius > 1.25 * radius || this.radius < 0.6 * radius || this.centre.distanceTo(centre) > 0.3 * radius) this.look("Iso");
    if (data.shades.length) this.shadeBox.replaceChildren(...[["", "none"], ...data.shades.map((s) => [s.key, s.label])].map(([value, text]) => element("option", { value }, text)));
    this.wanted ??= data.shades[0]?.key;
    this.shadeBox.value = data.shades.some((s) => s.key === this.wanted) ? this.wanted : "";
    this.colour(this.shadeBox.value, false);
    this.cut();
    this.turn(this.angle, true);
  }

  build() {
    this.bodies = this.data.bodies.map((body) => {
      const { geometry, edges } = displayGeometry(body);
      const node = new Group();
      const material = new MeshStandardMaterial({ roughness: 0.62, metalness: 0.08, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
      const mesh = new Mesh(geometry, material);
      const lines = new LineSegments(edges, new LineBasicMaterial({ transparent: true, opacity: 0.55 }));
      mesh.renderOrder = lines.renderOrder = 100;
      node.add(mesh, lines);
      this.world.add(node);
      return { ...body, node, mesh, lines, geometry };
    });
    const reach = new Box3();
    for (let f = 0; f < this.data.frames; f += Math.max(1, Math.floor(this.data.frames / 24))) {
      this.place(this.data.angles[f]);
      reach.union(new Box3().setFromObject(this.world, true));
    }
    this.centre = reach.getCenter(new Vector3());
    this.extent = reach.getSize(new Vector3());
    this.radius = this.extent.length() / 2;
    this.section = new Section(4 * this.radius);
    this.bodies.forEach((body, i) => {
      this.section.fit(body.node, body.geometry, this.scene, i + 1, body.role);
      body.mesh.material.clippingPlanes = body.lines.material.clippingPlanes = [];
    });
  }

  panel() {
    const { data } = this;
    this.readout = element("output", { class: "readout" });
    this.playButton = button("Play", "Run the mechanism", () => this.play(!this.playing));
    this.slide = slider("Cam angle", data.angles[0], data.angles[data.frames - 1], 0.5, this.angle, (v) => { this.play(false); this.turn(v); });
    const shades = select("Colour", [["", "none"], ...data.shades.map((s) => [s.key, s.label])], (key) => this.colour(key));
    this.shadeBox = shades.box;
    const cut = select("Section", [["off", "off"], ["x", "across X"], ["y", "across Y"], ["z", "across Z"]], () => this.cut());
    this.cutAxis = cut.box;
    this.cutAt = slider("Section position", 0, 1, 0.005, 0.5, () => this.cut());
    this.cutAt.disabled = true;
    const holds = select("Hold still", [["frame", "the frame"], ["cam", "the cam"]], (v) => { this.hold = v === "cam"; this.turn(this.angle); });
    const views = element("span", { class: "views", role: "group", "aria-label": "View" });
    for (const name of Object.keys(VIEWS)) views.append(button(name, `Look from: ${name}`, () => this.look(name)));
    const rows = [element("div", { class: "row" }, this.playButton, this.slide, this.readout)];
    rows.push(element("div", { class: "row" }, shades.row, cut.row, this.cutAt, holds.row, views));
    this.key = element("div", { class: "key" });
    this.tip = element("div", { class: "tip", hidden: "" });
    this.stage.append(this.key, this.tip);
    this.marks = new Marks(this.stage);
    this.figure.querySelector(".controls").replaceChildren(...rows);
    if (data.frames < 2) rows[0].hidden = true;
    if (data.shades.length) { shades.box.value = data.shades[0].key; this.colour(data.shades[0].key); } else if (!this.figure.dataset.live) shades.row.hidden = true;
  }

  colour(key, chosen = true) {
    if (chosen) this.wanted = key;
    this.shade = this.data.shades.find((shade) => shade.key === key) ?? null;
    for (const body of this.bodies) {
      const codes = this.shade && body.fields[key];
      paint(body.geometry, body, codes, this.shade?.groups ?? []);
      body.painted = Boolean(codes);
    }
    this.key.replaceChildren(...(this.shade ? [legend(this.shade)] : []));
    this.theme();
  }

  theme(paper = false) {
    const style = getComputedStyle(this.figure);
    const read = (name) => style.getPropertyValue(paper ? `--print-${name}` : `--view-${name}`).trim() || "#808080";
    for (const body of this.bodies) {
      const base = new Color(read(body.role));
      const { material } = body.mesh;
      material.map?.dispose();
      material.map = body.painted ? ramp(this.shade.scale, base) : null;
      material.color.set(body.painted ? 0xffffff : base);
      material.needsUpdate = true;
      body.lines.material.color.set(read("edge"));
    }
    this.section.colour(read("cut"), read("edge"));
    this.ask();
  }

  cut() {
    const axis = this.cutAxis.value;
    this.cutAt.disabled = axis === "off";
    if (axis !== "off") {
      const low = this.centre[axis] - this.extent[axis] / 2;
      this.section.set(axis, low + Number(this.cutAt.value) * this.extent[axis]);
    } else this.section.set("off", 0);
    for (const body of this.bodies) {
      body.mesh.material.clippingPlanes = body.lines.material.clippingPlanes = this.section.on ? [this.section.plane] : [];
    }
    this.ask();
  }

  look(name) {
    const direction = new Vector3(...(name === "Iso" && this.data.eye || VIEWS[name])).normalize();
    this.camera.position.copy(this.centre).addScaledVector(direction, 4 * this.radius);
    this.camera.near = 0.1 * this.radius;
    this.camera.far = 10 * this.radius;
    this.camera.zoom = 1;
    this.orbit.target.copy(this.centre);
    this.orbit.update();
    this.camera.updateMatrixWorld();
    const seen = [0, 1, 2].map((row) => new Vector3().setFromMatrixColumn(this.camera.matrixWorld, row));
    this.spread = seen.slice(0, 2).map((v) => (Math.abs(v.x) * this.extent.x + Math.abs(v.y) * this.extent.y + Math.abs(v.z) * this.extent.z) / 2);
    this.resize();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.stage;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height);
    const [x, y] = this.spread;
    const half = 1.08 * Math.max(y, (x * height) / width);
    Object.assign(this.camera, { left: (-half * width) / height, right: (half * width) / height, top: half, bottom: -half });
    this.camera.updateProjectionMatrix();
    this.ask();
  }

  place(angle) {
    const { angles, frames } = this.data;
    let f = 0;
    if (frames > 1) {
      f = Math.min(frames - 2, Math.max(0, Math.floor(((angle - angles[0]) / (angles[frames - 1] - angles[0])) * (frames - 1))));
      while (f > 0 && angles[f] > angle) f--;
      while (f < frames - 2 && angles[f + 1] < angle) f++;
    }
    const share = frames > 1 ? Math.min(1, Math.max(0, (angle - angles[f]) / (angles[f + 1] - angles[f]))) : 0;
    this.at = { f, share };
    for (const { poses, node } of this.bodies) {
      if (!poses) continue;
      const a = poses.subarray(7 * f, 7 * f + 7), b = frames > 1 ? poses.subarray(7 * f + 7, 7 * f + 14) : a;
      node.quaternion.fromArray(a).slerp(new Quaternion().fromArray(b), share);
      node.position.fromArray(a, 4).lerp(new Vector3().fromArray(b, 4), share);
    }
    this.world.quaternion.identity();
    this.world.position.set(0, 0, 0);
    const cam = this.bodies.find((body) => body.role === "cam" && body.poses);
    if (this.hold && cam) {
      this.world.quaternion.copy(cam.node.quaternion).invert();
      this.world.position.copy(cam.node.position).negate().applyQuaternion(this.world.quaternion);
    }
    this.world.updateMatrixWorld(true);
  }

  turn(angle, told = false) {
    this.angle = angle;
    this.place(angle);
    this.slide.value = angle;
    const { f, share } = this.at;
    const parts = [`${angle.toFixed(1)}°`];
    for (const { label, unit, values } of this.data.readouts) {
      const value = values[f] + share * ((values[f + 1] ?? values[f]) - values[f]);
      parts.push(`${label} ${figureText(value)}${unit ? "\u202f" + unit : ""}`);
    }
    this.readout.textContent = parts.join("   ");
    if (!told) document.dispatchEvent(new CustomEvent("camangle", { detail: { angle, from: this } }));
    this.ask();
  }

  play(on) {
    if (on === this.playing) return;
    this.playing = on;
    this.playButton.textContent = on ? "Pause" : "Play";
    let before = null;
    const { angles, frames } = this.data;
    const low = angles[0], span = angles[frames - 1] - low;
    const step = (now) => {
      if (!this.playing) return;
      if (before !== null && this.seen) this.turn(low + ((this.angle - low + ((now - before) / 1000 / SECONDS_PER_TURN) * span) % span));
      before = now;
      requestAnimationFrame(step);
    };
    if (on) requestAnimationFrame(step);
  }

  probe(event) {
    if (event.buttons || this.playing || !this.shade) { this.tip.hidden = true; return; }
    const box = this.renderer.domElement.getBoundingClientRect();
    const at = new Vector2(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
    const ray = new Raycaster();
    ray.setFromCamera(at, this.camera);
    const hit = ray.intersectObjects(this.bodies.map((body) => body.mesh)).find((h) => this.section.shows(h.point));
    const body = hit && this.bodies.find((b) => b.mesh === hit.object);
    const codes = body?.painted && body.fields[this.shade.key];
    const value = codes && sample(hit, body, codes);
    this.tip.hidden = value === undefined || value === false || Number.isNaN(value);
    if (this.tip.hidden) return;
    const number = this.shade.low + (value / 65534) * (this.shade.high - this.shade.low);
    this.tip.textContent = `${this.shade.label} ${figureText(number)}${this.shade.unit ? "\u202f" + this.shade.unit : ""}`;
    const x = Math.min(event.clientX - box.left + 14, box.width - this.tip.offsetWidth - 4);
    this.tip.style.transform = `translate(${x}px, ${Math.max(event.clientY - box.top - 30, 4)}px)`;
  }

  ask() {
    if (this.queued) return;
    this.queued = true;
    requestAnimationFrame(() => { this.queued = false; this.render(); });
  }

  render() {
    this.renderer.render(this.scene, this.camera);
    const { clientWidth: width, clientHeight: height } = this.stage;
    if (width && height) this.marks.update(this.camera, width, height);
    this.figure.dataset.ready = "true";
  }
}

// Field value at a hit by its barycentric share of the three corners.
function sample(hit, body, codes) {
  const corner = hit.face.a;
  const point = body.node.worldToLocal(hit.point.clone());
  const p = body.geometry.getAttribute("position");
  const [a, b, c] = [0, 1, 2].map((k) => new Vector3().fromBufferAttribute(p, corner + k));
  const ab = b.clone().sub(a), ac = c.clone().sub(a), ap = point.sub(a);
  const d = [ab.dot(ab), ab.dot(ac), ac.dot(ac), ap.dot(ab), ap.dot(ac)];
  const det = d[0] * d[2] - d[1] * d[1] || 1;
  const v = (d[2] * d[3] - d[1] * d[4]) / det, w = (d[0] * d[4] - d[1] * d[3]) / det;
  const values = [0, 1, 2].map((k) => codes[body.faces[corner + k]]);
  if (values.includes(65535)) return NaN;
  return Math.min(65534, Math.max(0, values[0] * (1 - v - w) + values[1] * v + values[2] * w));
}

// Two rows of 256: below the plain colour, above the scale.
function ramp(hex, base) {
  const data = new Uint8Array(4 * 512);
  const plain = base.getRGB({}, SRGBColorSpace);
  for (let i = 0; i < 256; i++) {
    data.set([255 * plain.r, 255 * plain.g, 255 * plain.b, 255], 4 * i);
    data.set([0, 2, 4].map((c) => parseInt(hex.slice(6 * i + c, 6 * i + c + 2), 16)), 4 * (256 + i));
    data[4 * (256 + i) + 3] = 255;
  }
  const texture = new DataTexture(data, 256, 2, RGBAFormat);
  texture.colorSpace = SRGBColorSpace;
  texture.minFilter = texture.magFilter = LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

async function start(figure) {
  const stage = figure.querySelector(".stage");
  const still = stage.querySelector(".poster");
  try {
    const data = await unpackScene(JSON.parse(figure.querySelector("script").textContent));
    figure.viewer = new Viewer(figure, data);
  } catch (error) {
    figure.classList.add("without");
    const word = element("p", {});
    word.textContent = `The 3D view cannot start in this browser (${error.message}): this is a still at the first cam angle. The drawing, the maps and the tables hold the same facts.`;
    stage.replaceChildren(...(still ? [still] : []), word);
  }
}

// A page that changes while it is looked at starts its view when the first bodies are there.
globalThis.camgeomScene = start;
for (const figure of document.querySelectorAll("figure.scene:not([data-live])")) start(figure);
