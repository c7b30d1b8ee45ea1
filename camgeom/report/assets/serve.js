// The page of `camgeom serve`: a form made from the schema, one request at a time, the newest wish wins.
(() => {
  const find = (id) => document.getElementById(id);
  const node = (name, attributes = {}, ...children) => {
    const made = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) {
      if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
      else if (value === true) made.setAttribute(key, "");
      else if (value !== undefined && value !== false) made.setAttribute(key, value);
    }
    made.append(...children);
    return made;
  };
  const file = JSON.parse(find("state").textContent);
  const tab = crypto.randomUUID?.() ?? String(Math.random());
  const store = `camgeom ${location.pathname} ${file.name}`;
  const figure = document.querySelector("figure.scene");
  const state = {
    saved: { text: file.text ?? "", digest: file.digest }, text: file.text ?? "", data: {}, kept: "", pending: {}, serial: 0,
    busy: null, wanted: false, history: [], at: -1, gesture: 0, pushed: -1, extra: new Set(), schema: null, shape: "", lift: null, groups: {},
  };

  // ---- asking -----------------------------------------------------------------------------------------------------

  function change(key, value) {
    state.pending[key] = value;
    state.by = state.gesture;
    ask();
  }

  function setText(text) {
    state.pending = {};
    state.text = text;
    state.by = state.gesture;
    ask(true);
  }

  // What an answer shows within this time it shows also while something is dragged, and its first checks in any case, ms.
  const PATIENCE = 100;
  const enough = (busy) => busy.seen && performance.now() - busy.began > PATIENCE;

  async function ask(at_once = false) {
    state.wanted = true;
    if (state.busy) {
      if (at_once || enough(state.busy)) state.busy.control.abort();
      return;
    }
    while (state.wanted) {
      state.wanted = false;
      await once();
    }
  }

  async function once() {
    const control = new AbortController();
    const changes = { ...state.pending };
    const began = performance.now();
    const busy = (state.busy = { control, seen: false, by: state.by, began });
    const text = state.text;
    const times = {};
    try {
      const answer = await fetch("answer", {
        method: "POST", signal: control.signal,
        body: JSON.stringify({ tab, serial: ++state.serial, text, changes, kept: state.kept, width: find("plots").clientWidth }),
      });
      if (!answer.ok) throw new Error((await answer.json()).reason);
      for await (const stage of lines(answer.body)) {
        if (text !== state.text && !busy.known) return; // another text was set meanwhile
        if (stage.stage === "profile" || stage.stage === "problems") {
          busy.known = true;
          for (const [key, value] of Object.entries(changes)) if (state.pending[key] === value) delete state.pending[key];
        }
        await show(stage, busy);
        times[stage.stage] = performance.now() - began;
        document.body.dataset[`${stage.stage}Ms`] = times[stage.stage].toFixed(1);
        if (["checks", "problems"].includes(stage.stage)) busy.seen = true;
        if (enough(busy) && state.wanted) { control.abort(); return; }
      }
      const told = Object.entries(times).filter(([name]) => !["profile", "done"].includes(name));
      find("cost").textContent = told.map(([name, ms]) => `${name} ${ms.toFixed(0)} ms`).join(", ");
      clearNotice("gone");
    } catch (error) {
      if (error.name !== "AbortError") lost(error);
    } finally {
      state.busy = null;
      document.body.dataset.idle = String(!state.wanted);
    }
  }

  async function* lines(body) {
    const reader = body.pipeThrough(new TextDecoderStream()).getReader();
    let rest = "";
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      const parts = (rest + value).split("\n");
      rest = parts.pop();
      for (const part of parts) yield JSON.parse(part);
    }
  }

  async function show(stage, busy) {
    document.body.dataset.idle = "false";
    if (stage.stage === "profile" || stage.stage === "problems") {
      const typed = document.activeElement === find("toml");
      state.text = stage.text;
      state.data = stage.data;
      remember(busy.by);
      form();
      if (!typed) find("toml").value = stage.text;
      problems(stage.problems ?? []);
      segments();
    } else if (stage.stage === "motion") {
      if (stage.reason) return notice("made", `This profile cannot be computed: ${stage.reason}`, "fail");
      clearNotice("made");
      find("title").textContent = document.title = stage.title;
      find("kind").textContent = stage.kind;
      Object.assign(state, { lift: stage.lift, unit: stage.unit, span: stage.span, over: stage.over, per: stage.per });
      segments();
      diagram();
    } else if (stage.html) {
      const box = find("judged");
      box.innerHTML = stage.html;
      box.classList.remove("old");
      box.firstElementChild.classList.toggle("first", !stage.whole);
      if (!stage.whole) box.firstElementChild.append(node("p", { class: "waiting" }, `Still to come: what ${stage.waiting} say.`));
    } else if (["checks", "loaded", "bodies", "verdict"].includes(stage.stage) && stage.reason) {
      find("judged").classList.remove("old");
      find("judged").replaceChildren(node("section", { class: "verdict fail" }, node("h2", {}, "Cannot be judged"), node("p", {}, stage.reason)));
    } else if (stage.stage === "coarse" || stage.stage === "fine") {
      const bare = find("noscene");
      bare.hidden = !stage.reason;
      figure.classList.toggle("old", Boolean(stage.reason));
      if (stage.reason) bare.textContent = `No body: ${stage.reason}`;
      else await scene(stage.scene);
    }
    if (stage.stage === "profile" || stage.stage === "problems") outdated();
    else if (["motion", "figures", "load", "fine"].includes(stage.stage)) {
      state.groups[stage.stage] = stage;
      figures();
      if (stage.plots || stage.reason) plots();
    }
  }

  // Until another value's answer has come, what stands there is the former value's, and looks it.
  function outdated() {
    for (const group of Object.values(state.groups)) group.old = true;
    for (const shown of [find("judged"), figure, ...document.querySelectorAll("#plots > *, #figures tbody tr")]) shown.classList.add("old");
  }

  async function scene(text) {
    const before = figure.viewer;
    if (before) return before.show(JSON.parse(text));
    if (figure.classList.contains("without")) return undefined;
    figure.querySelector("script").textContent = text;
    return globalThis.camgeomScene(figure);
  }

  // ---- undo, keeping, saving --------------------------------------------------------------------------------------

  // All that one gesture does is one step back.
  function remember(gesture) {
    if (state.history[state.at] !== state.text) {
      if (state.pushed === gesture && state.at > 0) state.history[state.at] = state.text;
      else state.history.splice(++state.at, Infinity, state.text);
      state.pushed = gesture;
    }
    marks();
  }

  function marks() {
    const dirty = state.text !== state.saved.text;
    find("undo").disabled = state.at <= 0;
    find("redo").disabled = state.at >= state.history.length - 1;
    find("dirty").hidden = !dirty;
    find("save").disabled = !dirty;
    find("file").textContent = `· ${file.name}`;
    for (const id of ["drop", "swap"]) find(id).hidden = !state.kept;
    try {
      if (dirty) sessionStorage.setItem(store, state.text); else sessionStorage.removeItem(store);
    } catch { /* a browser that keeps nothing: the page itself does */ }
  }

  function step(by) {
    const text = state.history[state.at + by];
    if (text === undefined) return;
    state.at += by;
    state.pushed = -1;
    setText(text);
  }

  function keep(text) {
    state.kept = text;
    marks();
    ask(true);
  }

  async function save(name) {
    const text = state.text;
    try {
      const answer = await fetch("save", { method: "POST", body: JSON.stringify({ text, name, known: state.saved.digest }) });
      const told = await answer.json();
      if (!answer.ok) return notice("save", `Not saved: ${told.reason}.`, "fail");
      if (told.saved === file.name) state.saved = { text, digest: told.digest };
      notice("save", `Saved ${told.saved}.${told.kept ? ` What it held is in ${told.kept}.` : ""}`);
      marks();
    } catch (error) { lost(error); }
  }

  // ---- notices ----------------------------------------------------------------------------------------------------

  function notice(id, text, level = "", ...buttons) {
    clearNotice(id);
    const shut = node("button", { onclick: () => clearNotice(id), "aria-label": "Close this notice" }, "×");
    find("notices").append(node("div", { class: `notice ${level}`, id: `notice-${id}` }, node("span", {}, text), ...buttons, shut));
  }

  function clearNotice(id) { find(`notice-${id}`)?.remove(); }

  function lost() {
    if (find("notice-gone")) return;
    const copy = node("button", { onclick: () => navigator.clipboard?.writeText(state.text) }, "Copy the text");
    const load = node("button", { onclick: download }, "Download the text");
    notice("gone", `The server does not answer: start camgeom serve again and open the address it prints. Nothing is lost: this page keeps the profile with every change.`, "fail", copy, load);
  }

  function download() {
    const link = node("a", { href: URL.createObjectURL(new Blob([state.text], { type: "application/toml" })), download: file.name });
    link.click();
    URL.revokeObjectURL(link.href);
  }

  async function watch() {
    try {
      const now = await (await fetch("file")).json();
      clearNotice("gone");
      if (now.reason) notice("file", `The file cannot be read: ${now.reason}`, "fail");
      else if (now.digest !== state.saved.digest && now.digest !== state.seen) {
        state.seen = now.digest;
        const take = () => { state.saved = now; state.gesture++; clearNotice("file"); setText(now.text); };
        const mine = () => { state.saved = now; clearNotice("file"); marks(); };
        if (state.text === state.saved.text) { take(); notice("file", "The file was changed outside: its new text is shown. Undo brings the one before."); }
        else notice("file", "The file was changed outside, and this page has changes of its own.", "",
          node("button", { onclick: take }, "Show the file's (Undo brings mine back)"), node("button", { onclick: mine }, "Keep mine"));
      }
    } catch { lost(); }
    setTimeout(watch, 1000);
  }

  function problems(found) {
    for (const field of document.querySelectorAll(".field.bad")) { field.classList.remove("bad"); field.querySelector(".wrong")?.remove(); }
    clearNotice("problems");
    const rest = [];
    for (const { key, text } of found) {
      const field = document.querySelector(`.field[data-key="${CSS.escape(key)}"]`);
      if (!field) { rest.push(text); continue; }
      field.classList.add("bad");
      field.append(node("p", { class: "wrong" }, text));
      field.closest("details").open = true;
    }
    if (found.length) {
      const told = rest.length ? rest.join("; ") : "See the marked values";
      notice("problems", `${told}. Below stands the last profile that could be computed.`, "fail");
    }
  }

  // ---- the form ---------------------------------------------------------------------------------------------------

  const SECTIONS = ["cam", "follower", "roller", "operation", "material.cam", "material.roller", "limits", "dynamics", "impact", "cutter", "output", "drawing"];
  const at = (data, path) => path.split(".").reduce((found, key) => found?.[key], data);

  function solved(schema) {
    let found = schema;
    while (found?.$ref) found = { ...state.schema.$defs[found.$ref.split("/").pop()], ...found, $ref: undefined };
    return found;
  }

  // The schema of a section, of the kind or shape that the data names.
  function sectionSchema(path) {
    let found = solved(state.schema);
    let data = state.data;
    for (const key of path.split(".")) {
      found = solved(found.properties?.[key]);
      data = data?.[key];
      if (found?.oneOf) {
        const fits = found.oneOf.find((one) => Object.entries(one.properties).some(([name, p]) => p.const !== undefined && p.const === data?.[name]));
        found = fits ?? found.oneOf[0];
      }
      if (!found) return null;
    }
    return found;
  }

  function form() {
    if (!state.schema) return;
    const shape = JSON.stringify([state.data.units, SECTIONS.map((path) => Object.keys(at(state.data, path) ?? {})), state.data.cam?.kind, state.data.follower?.kind, state.data.roller?.shape, [...state.extra]]);
    if (shape !== state.shape) {
      state.shape = shape;
      const absent = SECTIONS.filter((path) => at(state.data, path) === undefined && !state.extra.has(path) && sectionSchema(path)?.properties);
      const units = state.data.units === undefined ? [] : [field("units", state.schema.properties.units, state.data.units, false)];
      find("form").replaceChildren(field("name", { type: "string", description: "shown in reports" }, state.data.name, false), ...units, ...SECTIONS.map(section).filter(Boolean), adder("Add a table…", absent, (path) => state.extra.add(path)));
    } else {
      for (const box of document.querySelectorAll("#form .field")) box.refresh?.(at(state.data, box.dataset.key));
    }
  }

  function adder(title, names, chosen) {
    if (!names.length) return "";
    const box = node("select", { class: "add", "aria-label": title }, node("option", { value: "" }, title), ...names.map((name) => node("option", { value: name }, name)));
    box.addEventListener("change", () => { chosen(box.value); form(); });
    return box;
  }

  function section(path) {
    const data = at(state.data, path);
    const schema = sectionSchema(path);
    if (!schema?.properties || (data === undefined && !state.extra.has(path))) return null;
    const names = Object.keys(schema.properties).filter((name) => !["table", "force"].includes(name));
    const stated = names.filter((name) => data?.[name] !== undefined || state.extra.has(`${path}.${name}`) || (data === undefined && schema.required?.includes(name)));
    const simple = (name) => { const own = solved(schema.properties[name]); return own && !own.properties && !own.oneOf; };
    const fields = stated.filter(simple).map((name) => field(`${path}.${name}`, solved(schema.properties[name]), data?.[name], !schema.required?.includes(name)));
    const more = names.filter((name) => !stated.includes(name) && simple(name) && solved(schema.properties[name]).const === undefined);
    const force = data?.force ? node("p", { class: "hint" }, `${data.force.length} applied force(s): in the TOML text`) : "";
    return node("fieldset", {}, node("legend", {}, path), ...fields, force, adder("Add a key…", more, (name) => state.extra.add(`${path}.${name}`)));
  }

  // The meaning of a key in the unit in which the profile states it.
  function inUnits(name, text) {
    if (state.data.units !== "inch" || !text || name.endsWith("_mm")) return text;
    const turns = ["swinging", "turret"].includes(state.data.follower?.kind);
    return turns && /^(mm \((or )?deg|deg \(mm)/.test(text) ? text : text.replace(/^mm(?![\w/²³^])|(?<=^deg \()mm/, "in");
  }

  function field(key, schema, value, optional) {
    const name = key.split(".").pop();
    const id = `field-${key}`;
    const number = schema.type === "number" || schema.type === "integer" || (schema.anyOf && typeof value === "number");
    const box = node("div", { class: "field", "data-key": key });
    const about = [inUnits(name, schema.description), schema.default !== undefined && value === undefined ? `default ${JSON.stringify(schema.default)}` : ""].filter(Boolean).join("; ");
    const gone = optional ? node("button", { title: `Take ${name} away`, onclick: () => { state.gesture++; state.extra.delete(key); change(key, null); } }, "×") : "";
    let input;
    let set;
    if (schema.const !== undefined || schema.enum) {
      input = node("select", { id, disabled: schema.const !== undefined }, ...(schema.enum ?? [schema.const]).map((word) => node("option", { value: word }, word)));
      set = (v) => { input.value = v ?? ""; };
      input.addEventListener("change", () => { state.gesture++; change(key, input.value); });
    } else if (schema.type === "boolean") {
      input = node("input", { id, type: "checkbox" });
      set = (v) => { input.checked = Boolean(v); };
      input.addEventListener("change", () => { state.gesture++; change(key, input.checked); });
    } else if (number) {
      input = node("input", { id, type: "number", step: "any", inputmode: "decimal" });
      const range = node("input", { type: "range", "aria-label": `${key}, slider` });
      set = (v) => {
        if (document.activeElement !== input) input.value = v ?? "";
        if (document.activeElement !== range || !range.matches(":active")) span(range, schema, v);
      };
      const typed = () => {
        if (input.value === "" || !Number.isFinite(Number(input.value))) { wrong(box, `${key}: needs a number, with a point for decimals`); return; }
        change(key, Number(input.value));
      };
      input.addEventListener("input", typed);
      range.addEventListener("input", () => { input.value = Number(Number(range.value).toPrecision(10)); change(key, Number(input.value)); });
      for (const one of [input, range]) one.addEventListener("change", () => { state.gesture++; });
      range.addEventListener("pointerdown", () => { state.gesture++; });
      if (value === undefined) range.hidden = true;
      box.append(node("label", { for: id }, name), input, gone, range);
    } else {
      input = node("input", { id, type: "text" });
      const list = schema.type === "array";
      set = (v) => { if (document.activeElement !== input) input.value = list ? JSON.stringify(v ?? []) : v ?? ""; };
      input.addEventListener("change", () => {
        state.gesture++;
        try { change(key, list ? JSON.parse(input.value) : input.value); } catch { wrong(box, `${key}: needs a list such as ["stl", "3mf"]`); }
      });
    }
    if (!number) box.append(node("label", { for: id }, name), input, gone);
    if (about) box.append(node("p", { class: "about" }, about));
    set(value);
    box.refresh = set;
    return box;
  }

  function wrong(box, text) {
    box.classList.add("bad");
    box.querySelector(".wrong")?.remove();
    box.append(node("p", { class: "wrong" }, text));
  }

  // A slider about the value: half to one and a half of it, within what the schema allows.
  function span(range, schema, value) {
    const v = Number(value ?? 0);
    const size = Math.abs(v) || 10;
    const step = schema.type === "integer" ? 1 : 10 ** (Math.floor(Math.log10(size)) - 2);
    const least = schema.minimum ?? (schema.exclusiveMinimum !== undefined ? Math.max(schema.exclusiveMinimum, step) : -Infinity);
    const most = schema.maximum ?? schema.exclusiveMaximum ?? Infinity;
    const low = Math.max(least, v - size / 2), high = Math.min(most, v + Math.max(size / 2, 2 * step));
    Object.assign(range, { min: Math.floor(low / step) * step, max: Math.ceil(high / step) * step, step, value: v });
    if (Number(range.min) < least) range.min = least;
  }

  // ---- figures and plots ------------------------------------------------------------------------------------------

  function figures() {
    const told = ["motion", "figures", "load", "fine"].map((name) => state.groups[name]).filter(Boolean);
    const was = new Map((state.kept ? told : []).flatMap((one) => one.kept ?? []).map((one) => [one.label, one]));
    const head = ["Figure", "Value", ...(was.size ? ["Kept"] : []), ""];
    const rows = told.flatMap((one) => (one.figures ?? []).map((figure) => [figure, one.old])).map(([{ label, value, unit, note }, old]) => {
      const cells = [node("td", {}, label), node("td", { class: "n" }, `${value} ${unit}`.trim())];
      if (was.size) cells.push(node("td", { class: "n was" }, was.has(label) ? `${was.get(label).value} ${was.get(label).unit}`.trim() : "–"));
      return node("tr", { class: old && "old" }, ...cells, node("td", { class: "hint" }, note ?? ""));
    });
    find("figures").replaceChildren(node("div", { class: "scroll" }, node("table", {}, node("thead", {}, node("tr", {}, ...head.map((word, i) => node("th", { class: i === 1 || (i === 2 && was.size) ? "n" : undefined }, word)))), node("tbody", {}, ...rows))));
  }

  function plots() {
    const groups = ["motion", "figures"].map((name) => state.groups[name]).filter(Boolean);
    const drawn = groups.flatMap((group) => (group.plots ?? [group]).map((plot) => [plot, group.old]));
    find("plots").replaceChildren(...drawn.map(([{ caption, svg, reason }, old]) => {
      if (reason) return node("p", { class: old ? "bad old" : "bad" }, reason);
      const made = node("figure", { class: old ? "full old" : "full" }, node("figcaption", {}, caption));
      made.insertAdjacentHTML("beforeend", svg);
      return made;
    }));
    cursor(state.angle ?? 0);
  }

  function cursor(angle) {
    state.angle = angle;
    for (const path of document.querySelectorAll("#plots [data-cam]")) {
      const [x0, x1, low, high, ...heights] = path.dataset.cam.split(" ").map(Number);
      const x = (x0 + ((angle - low) / (high - low)) * (x1 - x0)).toFixed(1);
      let d = "";
      if (angle >= low && angle <= high) for (let i = 0; i < heights.length; i += 2) d += `M${x} ${heights[i]}V${heights[i + 1]}`;
      path.setAttribute("d", d);
    }
  }

  // ---- the timing diagram -----------------------------------------------------------------------------------------

  const WIDE = Math.min(720, Math.max(400, find("diagram").clientWidth)), HIGH = 250, LEFT = 56, RIGHT = 14, TOP = 14, FOOT = 30;
  const SVG = "http://www.w3.org/2000/svg";
  const shape = (name, attributes, text) => {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== undefined) made.textContent = text;
    return made;
  };
  const tidy = (value) => Number(value.toFixed(6));

  function scales() {
    if (state.held) return state.held.scales;
    const shown = state.lift.slice(0, Math.round(state.span * state.per) + 1);
    const low = Math.min(0, ...shown), high = Math.max(...shown, low + 1e-6), room = 0.12 * (high - low);
    return { low: low - room, high: high + room };
  }

  function diagram() {
    const motion = state.data.motion;
    if (!state.lift || !Array.isArray(motion)) return;
    const { low, high } = scales(), span = state.span;
    const x = (angle) => LEFT + (angle / span) * (WIDE - LEFT - RIGHT);
    const y = (value) => HIGH - FOOT - ((value - low) / (high - low)) * (HIGH - TOP - FOOT);
    const svg = shape("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, class: "plot", role: "group", "aria-label": "Timing diagram", "font-size": 13 });
    let start = 0;
    for (const one of motion) {
      if (one.to === undefined) svg.append(shape("rect", { class: "zone", x: x(start), y: TOP, width: Math.max(0, x(one.until) - x(start)), height: HIGH - TOP - FOOT }));
      start = one.until;
    }
    // Over a travel the ticks stand at round lengths.
    const decade = 10 ** Math.floor(Math.log10(span / 5)), fifth = span / 5 / decade;
    const stride = state.over !== "°" ? decade * (fifth > 5 ? 10 : fifth > 2 ? 5 : fifth > 1 ? 2 : 1) : span > 180 ? (WIDE < 600 ? 90 : 60) : 30;
    for (let angle = 0; angle <= span; angle += stride) {
      svg.append(shape("path", { class: "grid", d: `M${x(angle)} ${TOP}V${HIGH - FOOT}` }), shape("text", { class: "tick", x: x(angle), y: HIGH - FOOT + 16, "text-anchor": state.over !== "°" && angle > 0.95 * span ? "end" : "middle" }, `${tidy(angle)}${state.over}`));
    }
    const power = 10 ** Math.floor(Math.log10((high - low) / 3)), tick = power * ((high - low) / 3 / power > 5 ? 5 : (high - low) / 3 / power > 2 ? 2 : 1);
    for (let value = Math.ceil(low / tick) * tick; value <= high; value += tick) {
      svg.append(shape("path", { class: "grid", d: `M${LEFT} ${y(value)}H${WIDE - RIGHT}` }), shape("text", { class: "tick", x: LEFT - 6, y: y(value) + 4, "text-anchor": "end" }, String(tidy(value))));
    }
    svg.append(shape("text", { class: "axis", x: 4, y: 12 }, state.unit));
    const points = state.lift.slice(0, Math.round(span * state.per) + 1).map((value, at) => `${x(at / state.per).toFixed(1)} ${y(value).toFixed(1)}`);
    svg.append(shape("path", { class: "line s0", d: `M${points.join("L")}` }));
    motion.forEach((one, i) => {
      const spot = one.to ?? between(one.until);
      const words = `motion[${i}]: until ${one.until}${state.over}${one.to === undefined ? ", dwell" : `, to ${one.to} ${state.unit}`}`;
      const end = shape("circle", { class: "end", cx: x(one.until), cy: y(spot), r: 8, tabindex: 0, role: "slider", "aria-label": words, "aria-valuenow": one.until, "data-segment": i });
      end.append(shape("title", {}, words));
      end.addEventListener("pointerdown", (event) => hold(event, i, svg, { low, high }));
      end.addEventListener("keydown", (event) => nudge(event, i));
      svg.append(end);
    });
    const chosen = document.activeElement?.dataset?.segment;
    find("diagram").replaceChildren(svg);
    if (chosen !== undefined && !state.held) svg.querySelector(`[data-segment="${chosen}"]`)?.focus();
  }

  const between = (angle) => {
    const at = angle * state.per, i = Math.min(Math.floor(at), state.lift.length - 2);
    return state.lift[i] + (at - i) * (state.lift[i + 1] - state.lift[i]);
  };

  const lift = (fine) => (fine ? 0.01 : 0.1) / (state.unit === "in" ? 20 : 1);

  function moved(i, until, to, fine) {
    const motion = state.data.motion, last = i === motion.length - 1;
    const step = fine ? 0.05 : 0.5;
    if (!last && until !== null) {
      const least = (motion[i - 1]?.until ?? 0) + step, most = motion[i + 1].until - step;
      const angle = tidy(Math.min(most, Math.max(least, Math.round(until / step) * step)));
      if (angle !== motion[i].until) { motion[i].until = angle; change(`motion[${i}].until`, angle); }
    }
    if (motion[i].to !== undefined && to !== null) {
      const place = tidy(Math.round(to / lift(fine)) * lift(fine));
      if (place !== motion[i].to) { motion[i].to = place; change(`motion[${i}].to`, place); }
    }
  }

  function hold(event, i, svg, scales) {
    event.preventDefault();
    state.gesture++;
    state.held = { scales };
    const box = svg.getBoundingClientRect(), unit = WIDE / box.width, { low, high } = scales;
    const from = { x: event.clientX, y: event.clientY };
    const way = { x: false, y: false };
    const follow = (e) => {
      way.x ||= Math.abs(e.clientX - from.x) > 3;
      way.y ||= Math.abs(e.clientY - from.y) > 3;
      const angle = (((e.clientX - box.left) * unit - LEFT) / (WIDE - LEFT - RIGHT)) * state.span;
      const place = low + ((HIGH - FOOT - (e.clientY - box.top) * unit) / (HIGH - TOP - FOOT)) * (high - low);
      moved(i, way.x ? angle : null, way.y ? place : null, e.shiftKey);
      diagram();
    };
    const drop = () => {
      removeEventListener("pointermove", follow);
      removeEventListener("pointerup", drop);
      removeEventListener("pointercancel", drop);
      state.held = null;
      state.gesture++;
      diagram();
    };
    addEventListener("pointermove", follow);
    addEventListener("pointerup", drop);
    addEventListener("pointercancel", drop);
  }

  function nudge(event, i) {
    const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!by) return;
    event.preventDefault();
    state.gesture++;
    const one = state.data.motion[i], fine = event.shiftKey;
    moved(i, by[0] ? one.until + by[0] * (fine ? 0.05 : 0.5) : null, by[1] && one.to !== undefined ? one.to + by[1] * lift(fine) : null, fine);
    diagram();
  }

  function segments() {
    const motion = state.data.motion, table = find("segments");
    if (!Array.isArray(motion) || table.contains(document.activeElement)) return;
    const laws = (state.schema?.properties.motion.items.oneOf ?? []).map((one) => one.properties.law?.const).filter(Boolean);
    const number = (key, value) => {
      const box = node("input", { type: "number", step: "any", "aria-label": key });
      box.value = value;
      box.addEventListener("change", () => { state.gesture++; if (box.value !== "") change(key, Number(box.value)); });
      return box;
    };
    const rows = motion.map((one, i) => {
      const law = one.law === undefined ? "dwell" : node("select", { "aria-label": `motion[${i}].law`, onchange: (e) => { state.gesture++; change(`motion[${i}].law`, e.target.value); } }, ...laws.map((name) => node("option", { value: name, selected: name === one.law }, name)));
      return node("tr", {}, node("td", {}, `motion[${i}]`), node("td", {}, number(`motion[${i}].until`, one.until)), node("td", {}, one.to === undefined ? "" : number(`motion[${i}].to`, one.to)), node("td", {}, law));
    });
    table.replaceChildren(node("thead", {}, node("tr", {}, ...["Segment", `Until, ${(state.over ?? "°").trim()}`, `To, ${state.unit ?? ""}`, "Law"].map((word) => node("th", {}, word)))), node("tbody", {}, ...rows));
  }

  // ---- beginning --------------------------------------------------------------------------------------------------

  find("undo").addEventListener("click", () => step(-1));
  find("redo").addEventListener("click", () => step(1));
  find("keep").addEventListener("click", () => keep(state.text));
  find("drop").addEventListener("click", () => keep(""));
  find("swap").addEventListener("click", () => { const kept = state.kept; state.kept = state.text; state.gesture++; setText(kept); });
  find("save").addEventListener("click", () => save(file.name));
  find("saveas").addEventListener("click", () => {
    const box = node("input", { type: "text", "aria-label": "New file name", size: 28 });
    box.value = file.name.replace(/\.toml$/, "-variant.toml");
    const go = node("button", { onclick: () => { clearNotice("name"); save(box.value); } }, "Save");
    notice("name", "Save as a new file beside the profile:", "", box, go);
    box.focus();
  });
  let typing;
  find("toml").addEventListener("input", (event) => { clearTimeout(typing); typing = setTimeout(() => setText(event.target.value), 250); });
  find("toml").addEventListener("change", () => { state.gesture++; });
  addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.target.id === "toml") return;
    const key = event.key.toLowerCase();
    if (key === "s") { event.preventDefault(); if (!find("save").disabled) save(file.name); }
    else if (key === "z" || key === "y") { event.preventDefault(); step(key === "y" || event.shiftKey ? 1 : -1); }
  });
  addEventListener("beforeunload", (event) => { if (state.text !== state.saved.text) event.preventDefault(); });
  document.addEventListener("camangle", (event) => cursor(event.detail.angle));
  if (innerWidth < 1000) find("keys").open = false;

  (async () => {
    let left = null;
    try { left = sessionStorage.getItem(store); } catch { /* none is kept */ }
    state.schema = await (await fetch("schema")).json().catch(() => null);
    if (file.reason) notice("file", `The file cannot be read: ${file.reason}`, "fail");
    if (left !== null && left !== state.text) {
      const other = state.text;
      state.history = [other];
      state.at = 0;
      notice("left", "Changes of this tab that were not saved are back.", "", node("button", { onclick: () => { clearNotice("left"); setText(other); } }, "Show the file's"));
      setText(left);
    } else ask();
    setTimeout(watch, 1000);
  })();
})();
