// The 3D view of a build and the list beside it: what is chosen or pointed at on one side is shown on the other. build.sh bundles it with
// three.js into ../assets/view.js.
import { AmbientLight, Color, DirectionalLight, PerspectiveCamera, Plane, Raycaster, Scene, Vector2, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { Cake } from "./cake.js";
import { furniture } from "./furniture.js";
import { load } from "./load.js";
import { kindColour, orderColour, pale, scaleColour } from "./palette.js";

const section = document.querySelector("#view");
// What this script says comes with the page, in its language; values stand in braces.
const texts = JSON.parse(document.querySelector("#texts")?.textContent ?? "{}");
const text = (name, values = {}) => (texts[name] ?? name).replace(/\{(\w+)\}/g, (_, key) => values[key] ?? "");
const fixed = (number, digits) => number.toLocaleString(document.documentElement.lang, { minimumFractionDigits: digits, maximumFractionDigits: digits, useGrouping: false });
const least = (numbers) => numbers.reduce((a, b) => Math.min(a, b), Infinity), most = (numbers) => numbers.reduce((a, b) => Math.max(a, b), -Infinity);

/** What colours can mean: the colour of a copy, and a legend of colours with words. */
function colourings(data) {
  const orders = [...new Set(data.meshes.map((mesh) => mesh.order))].sort(), number = new Map(data.meshes.map((mesh, at) => [mesh, at]));
  const copies = data.meshes.flatMap((mesh) => mesh.copies);
  const dues = [...new Set(data.meshes.map((mesh) => mesh.due).filter(Boolean))].sort(), lastStep = most(copies.map((copy) => copy.step ?? 0));
  const steps = (words) => words.map((text, at) => [scaleColour(words.length > 1 ? at / (words.length - 1) : 0), text]);
  const low = least(copies.map((copy) => copy.low_mm)), top = data.height_mm ?? most(copies.map((copy) => copy.top_mm));
  const middle = (copy) => (copy.low_mm + copy.top_mm) / 2;
  const dueShare = (mesh) => (mesh.due ? dues.indexOf(mesh.due) / Math.max(dues.length - 1, 1) : null);
  const few = dues.length > 6 ? [dues[0], dues[dues.length >> 1], dues[dues.length - 1]] : dues;
  return {
    part: { colour: (mesh) => kindColour(number.get(mesh)), legend: [] },
    order: { colour: (mesh) => orderColour(orders.indexOf(mesh.order)), legend: orders.map((name, at) => [orderColour(at), name || text("no_order")]) },
    due: { colour: (mesh) => scaleColour(dueShare(mesh)), legend: [...steps(few), [scaleColour(null), text("no_date")]] },
    height: { colour: (_, copy) => scaleColour((middle(copy) - low) / (top - low || 1)), legend: steps([low, (low + top) / 2, top].map((mm) => `${mm.toFixed(0)} mm`)) },
    step: { colour: (_, copy) => scaleColour(copy.step ? 1 - (copy.step - 1) / Math.max(lastStep - 1, 1) : null), legend: lastStep ? steps([`${lastStep}: ${text("last_out")}`, `1: ${text("first_out")}`]) : [[scaleColour(null), text("no_proved_order")]] },
  };
}

function show(data) {
  const canvas = section.querySelector("canvas"), hover = section.querySelector("#hover"), entries = [...section.querySelectorAll("[data-part]")];
  const renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
  renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
  renderer.localClippingEnabled = true;
  const scene = new Scene(), style = (name) => getComputedStyle(section).getPropertyValue(name).trim() || "#5c6670";
  const [x, y, z] = data.volume_mm, size = Math.hypot(x, y, z);
  const camera = new PerspectiveCamera(35, 1, size / 200, size * 10); camera.up.set(0, 0, 1);
  const sun = new DirectionalLight("#ffffff", 2.2); camera.add(sun); sun.position.set(-0.4, 0.8, 0.5);
  scene.add(camera, new AmbientLight("#ffffff", 1.1));
  const knife = new Plane(new Vector3(0, 0, -1), z + 1), cake = new Cake(data, knife), meanings = colourings(data);
  scene.add(...cake.objects);
  let around = null;
  const theme = () => { scene.background = new Color(style("--canvas")); if (around) scene.remove(around); around = furniture(data.volume_mm, data.height_mm, style("--box"), style("--text"), text("front")); scene.add(around); paint(); };

  // What is chosen for good, and what is pointed at: { part } with the copy that was tapped, if any, or { order }; null = nothing. Other
  // pages link to the copies of a part, or to one of them.
  const linked = () => { const [, part, copy] = /^#part-(\d+)(?:-(\d+))?$/.exec(location.hash) ?? []; return part ? { part: Number(part), copy: copy && Number(copy) } : null; };
  let chosen = linked(), pointed = null;
  const fits = (mesh, what) => (what.part === undefined ? mesh.order === what.order : mesh.part === what.part);
  const same = (one, other) => one?.part === other?.part && one?.order === other?.order && one?.copy === other?.copy;
  const meaning = () => meanings[section.querySelector("#colour")?.value] ?? meanings.part;
  function paint() {
    const what = pointed ?? chosen, { colour } = meaning();
    const told = (mesh, copy) => (what?.copy === undefined || copy.copy === what.copy ? colour(mesh, copy) : pale(colour(mesh, copy)));
    cake.arrange((mesh) => !what || fits(mesh, what), told, style("--box"));
    draw();
  }
  function mark() {
    const parts = new Map(data.meshes.map((mesh) => [mesh.part, mesh])), { colour, legend } = meaning();
    for (const entry of entries) {
      const mesh = parts.get(Number(entry.dataset.part)), [copy] = mesh?.copies ?? [];
      entry.setAttribute("aria-pressed", String(Boolean(mesh && chosen && fits(mesh, chosen))));
      const swatch = entry.querySelector(".swatch");
      if (swatch) swatch.style.background = copy ? colour(mesh, copy) : "none";
    }
    for (const heading of section.querySelectorAll("[data-order]")) heading.setAttribute("aria-pressed", String(same(chosen, { order: heading.dataset.order })));
    section.querySelector("#legend")?.replaceChildren(...legend.map(([colour, words]) => {
      const line = document.createElement("span"), swatch = Object.assign(document.createElement("span"), { className: "swatch" });
      swatch.style.background = colour; line.append(swatch, ` ${words}`);
      return line;
    }));
  }
  // What is chosen is said where what is pointed at is said; the button that shows all undoes the choice.
  const chosenText = () => {
    const meshes = data.meshes.filter((mesh) => fits(mesh, chosen)), count = meshes.reduce((sum, mesh) => sum + mesh.copies.length, 0);
    const what = chosen.part === undefined ? chosen.order || text("what_has_no_order") : meshes[0]?.name ?? text("part_not_here");
    return text(count === 1 ? "chosen_one" : "chosen", { what, count });
  };
  const rest = () => (chosen ? chosenText() : text("hint"));
  const choose = (what) => {
    chosen = same(what, chosen) ? null : what; pointed = null; mark(); paint();
    hover.textContent = rest();
    section.querySelector("#home").textContent = chosen ? text("show_all") : text("whole_view");
  };
  const point = (what) => { if (same(what, pointed)) return; pointed = what; paint(); };
  addEventListener("hashchange", () => { chosen = linked(); mark(); paint(); });

  const controls = new OrbitControls(camera, canvas);
  // Looks from the front, slightly from the right and above, as near as possible with the whole build in view.
  const home = () => {
    const high = Math.min(z, Math.max(data.height_mm ?? z, z / 2)), back = new Vector3(0.5, -0.83, 0.42).normalize();
    const right = new Vector3(0, 0, 1).cross(back).normalize(), up = back.clone().cross(right), tall = Math.tan((camera.fov * Math.PI) / 360), wide = tall * camera.aspect;
    controls.target.set(x / 2, y / 2, high / 2);
    let distance = 0;
    for (const sx of [-x, x]) for (const sy of [-y, y]) for (const sz of [-high, high]) {
      const corner = new Vector3(sx, sy, sz).multiplyScalar(0.5);
      distance = Math.max(distance, corner.dot(back) + Math.max(Math.abs(corner.dot(right)) / wide, Math.abs(corner.dot(up)) / tall));
    }
    camera.position.copy(controls.target).addScaledVector(back, (camera.aspect < 1.2 ? 1.32 : 1.12) * distance); controls.update(); draw();
  };
  let asked = false;
  function draw() { if (asked) return; asked = true; requestAnimationFrame(() => { asked = false; camera.updateMatrixWorld(); around.userData.turn(camera); renderer.render(scene, camera); section.dataset.drawn = String(cake.count); }); }
  const fit = () => { const { clientWidth: w, clientHeight: h } = canvas; if (!w || !h) return; renderer.setSize(w, h, false); camera.aspect = w / h; camera.updateProjectionMatrix(); draw(); };
  controls.addEventListener("change", draw); new ResizeObserver(fit).observe(canvas);

  const top = data.height_mm ? data.height_mm * 1.001 : z, cut = section.querySelector("#cut"), said = section.querySelector("#cut-mm"), layers = Math.max(1, Math.ceil((data.height_mm ?? z) / data.layer_mm - 1e-6));
  const slice = () => {
    const height = top * cut.value / 1000, layer = Math.round(layers * cut.value / 1000);
    knife.constant = cut.value === "1000" ? 10 * z : height;
    said.textContent = `${text("layer", { height: fixed(height, 1), layer, layers })} `; cut.setAttribute("aria-valuetext", said.textContent); draw();
  };
  cut.addEventListener("input", slice);
  section.querySelector("#explode").addEventListener("input", (e) => { cake.explode = e.target.value / 60; paint(); });
  section.querySelector("#home").addEventListener("click", () => { if (chosen) choose(chosen); home(); });
  section.querySelector("#colour")?.addEventListener("change", () => { mark(); paint(); });

  const ray = new Raycaster(), mouse = new Vector2();
  const under = (event) => {
    const box = canvas.getBoundingClientRect();
    mouse.set((event.clientX - box.left) / box.width * 2 - 1, 1 - (event.clientY - box.top) / box.height * 2);
    ray.setFromCamera(mouse, camera);
    return cake.hit(ray, knife);
  };
  let hot = null;
  const tell = (found) => {
    const { mesh, copy } = found ?? {};
    hover.textContent = found ? [mesh.name, mesh.order && text("of_order", { order: mesh.order }), mesh.due && text("due", { due: mesh.due }),
      text("copy_from_to", { copy: copy.copy, low: fixed(copy.low_mm, 1), top: fixed(copy.top_mm, 1) }), copy.step && text("step", { step: copy.step })].filter(Boolean).join(", ")
      + (mesh.is_simplified ? ` ${text("simplified")}` : "") : rest();
    hot?.classList.remove("hot");
    hot = found ? entries.find((entry) => Number(entry.dataset.part) === found.mesh.part) : null;
    hot?.classList.add("hot");
  };
  let waiting = 0, down = null;
  canvas.addEventListener("pointermove", (event) => { if (event.buttons || performance.now() < waiting) return; const began = performance.now();
    const found = under(event); waiting = performance.now() + 2 * (performance.now() - began); tell(found); });
  canvas.addEventListener("pointerleave", () => tell(null));
  canvas.addEventListener("pointerdown", (e) => { down = [e.clientX, e.clientY]; });
  canvas.addEventListener("click", (e) => {
    if (down && Math.hypot(e.clientX - down[0], e.clientY - down[1]) > 4) return;
    const found = under(e);
    if (found) choose({ part: found.mesh.part, copy: found.copy.copy }); else if (chosen) choose(chosen);
    tell(found);
    if (found && hot) { const list = hot.closest(".view-list"); list.scrollTop = hot.offsetTop - list.offsetTop - list.clientHeight / 2; }
  });
  canvas.addEventListener("keydown", (e) => {
    const arm = camera.position.clone().sub(controls.target), up = new Vector3(0, 0, 1);
    if (e.key === "ArrowLeft" || e.key === "ArrowRight") arm.applyAxisAngle(up, e.key === "ArrowLeft" ? -0.15 : 0.15);
    else if (e.key === "ArrowUp" || e.key === "ArrowDown") arm.z += (e.key === "ArrowUp" ? 0.1 : -0.1) * arm.length();
    else if (e.key === "+" || e.key === "-") arm.multiplyScalar(e.key === "+" ? 0.9 : 1.1);
    else if (e.key === "Escape" && chosen) return choose(chosen);
    else return;
    e.preventDefault(); camera.position.copy(controls.target).add(arm); controls.update(); draw();
  });
  for (const [selector, of] of [["[data-part]", (e) => ({ part: Number(e.dataset.part) })], ["[data-order]", (e) => ({ order: e.dataset.order })]]) {
    for (const entry of section.querySelectorAll(selector)) {
      entry.addEventListener("click", () => choose(of(entry)));
      for (const begin of ["pointerenter", "focus"]) entry.addEventListener(begin, (e) => { if (e.pointerType !== "touch") point(of(entry)); });
      for (const end of ["pointerleave", "blur"]) entry.addEventListener(end, () => point(null));
    }
  }
  if (data.missing_copies > 0) {
    const gone = document.createElement("p"), all = section.dataset.copies;
    gone.className = "bad"; gone.textContent = text(all === "1" ? "missing_one" : "missing", { count: data.missing_copies, all });
    section.prepend(gone);
  }
  mark(); theme(); slice(); fit(); home();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", theme);
}

if (section) load(section.dataset.build).then(show).catch((error) => { section.querySelector("#hover").textContent = text("no_view", { why: error.message }); });
