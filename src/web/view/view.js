// The 3D view of a build: draws each mesh once, with its copies as instances. build.sh bundles it with three.js into
// ../assets/view.js.
import { AmbientLight, BufferAttribute, BufferGeometry, Box3, Box3Helper, Color, DirectionalLight, InstancedMesh, Matrix4, MeshLambertMaterial,
  PerspectiveCamera, Plane, Quaternion, Raycaster, Scene, Vector2, Vector3, WebGLRenderer } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

// Okabe and Ito's colours, which the colour-blind can tell apart, plain, lighter and darker: those of the pictures (format/shade).
const COLOURS = [[0, 114, 178], [230, 159, 0], [0, 158, 115], [204, 121, 167], [86, 180, 233], [213, 94, 0], [240, 228, 66]];
const colourOf = (number) => {
  const shade = [(c) => c, (c) => c + 0.45 * (255 - c), (c) => 0.62 * c][(number / COLOURS.length | 0) % 3];
  return new Color(`rgb(${COLOURS[number % COLOURS.length].map((c) => Math.round(shade(c))).join(",")})`);
};
const section = document.querySelector("#view");
const HINT = "Point at a copy to see what it is; click to see its siblings.";

// A report contains its scene; a page fetches it from the server.
async function fetched(build) {
  const inside = document.querySelector("#scene");
  if (inside) return Uint8Array.from(atob(inside.textContent), (letter) => letter.charCodeAt(0)).buffer;
  const answer = await fetch(`/builds/${build}/scene`);
  if (!answer.ok) throw new Error(`the server answers ${answer.status}`);
  return answer.arrayBuffer();
}

async function load(build) {
  const bytes = await fetched(build);
  const length = new DataView(bytes).getUint32(0, true);
  const scene = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
  let at = 4 + length;
  // Numbers are differences to the one before, in 16 bits: three runs of coordinates in steps of the mesh, then the corners.
  const run = (count, step) => { let sum = 0; const differences = new Uint16Array(bytes, at, count); at += 2 * count; for (let n = 0; n < count; n += 1) { sum = (sum + differences[n]) & 65535; step(sum, n); } };
  for (const mesh of scene.meshes) {
    mesh.positions = new Float32Array(3 * mesh.vertices);
    for (let axis = 0; axis < 3; axis += 1) run(mesh.vertices, (sum, n) => { mesh.positions[3 * n + axis] = mesh.low_mm[axis] + mesh.step_mm * sum; });
    mesh.indices = new Uint16Array(3 * mesh.triangles);
    run(3 * mesh.triangles, (sum, n) => { mesh.indices[n] = sum; });
  }
  return scene;
}

function show(data) {
  const canvas = section.querySelector("canvas"), hover = section.querySelector("#hover");
  const renderer = new WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
  renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
  renderer.localClippingEnabled = true;
  const scene = new Scene(), style = (name) => new Color(getComputedStyle(section).getPropertyValue(name).trim() || "#f4f5f6");
  const [x, y, z] = data.volume_mm, size = Math.hypot(x, y, z), middle = new Vector3(x / 2, y / 2, z / 2);
  const camera = new PerspectiveCamera(35, 1, size / 200, size * 10); camera.up.set(0, 0, 1);
  const sun = new DirectionalLight("#ffffff", 2.2); camera.add(sun); sun.position.set(-0.4, 0.8, 0.5);
  const box = new Box3Helper(new Box3(new Vector3(), new Vector3(x, y, z)));
  scene.add(camera, new AmbientLight("#ffffff", 1.1), box);
  const theme = () => { scene.background = style("--canvas"); box.material.color.copy(style("--box")); };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { theme(); draw(); });
  const knife = new Plane(new Vector3(0, 0, -1), z + 1);
  const instanced = [], chosen = new Color("#d40000"), turn = new Quaternion(), one = new Vector3(1, 1, 1), place = new Vector3(), matrix = new Matrix4();
  data.meshes.forEach((mesh, number) => {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(mesh.positions, 3));
    geometry.setIndex(new BufferAttribute(mesh.indices, 1));
    const material = new MeshLambertMaterial({ flatShading: true, clippingPlanes: [knife], side: 2 });
    const drawn = new InstancedMesh(geometry, material, mesh.copies.length);
    drawn.userData = { mesh, colour: colourOf(number) };
    scene.add(drawn); instanced.push(drawn);
  });
  // The page of a part links to its copies: /builds/1#part-7.
  const linked = () => Number(/^#part-(\d+)$/.exec(location.hash)?.[1]) || null;
  let marked = linked();
  addEventListener("hashchange", () => { marked = linked(); paint(); draw(); });
  const paint = () => instanced.forEach((drawn) => {
    const { mesh, colour } = drawn.userData;
    mesh.copies.forEach((_, at) => drawn.setColorAt(at, marked === mesh.part ? chosen : colour));
    if (drawn.instanceColor) drawn.instanceColor.needsUpdate = true;
  });
  const pose = (explode) => instanced.forEach((drawn) => {
    drawn.userData.mesh.copies.forEach((copy, at) => {
      place.fromArray(copy.translation_mm);
      const out = new Vector3((place.x - x / 2), (place.y - y / 2), (copy.low_mm + copy.top_mm) / 2).multiplyScalar(explode);
      turn.fromArray(copy.rotation);
      drawn.setMatrixAt(at, matrix.compose(place.clone().add(out), turn, one));
    });
    drawn.instanceMatrix.needsUpdate = true; drawn.computeBoundingSphere();
  });
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
    camera.position.copy(controls.target).addScaledVector(back, 1.06 * distance); controls.update(); draw();
  };
  let asked = false;
  const draw = () => { if (asked) return; asked = true; requestAnimationFrame(() => { asked = false; renderer.render(scene, camera); section.dataset.drawn = String(instanced.reduce((n, d) => n + d.count, 0)); }); };
  const fit = () => { const { clientWidth: w, clientHeight: h } = canvas; renderer.setSize(w, h, false); camera.aspect = w / h; camera.updateProjectionMatrix(); draw(); };
  controls.addEventListener("change", draw); new ResizeObserver(fit).observe(canvas);
  const top = data.height_mm ? data.height_mm * 1.001 : z, cut = section.querySelector("#cut"), said = section.querySelector("#cut-mm");
  const slice = () => { const height = top * cut.value / 1000; knife.constant = cut.value === "1000" ? 10 * z : height; said.textContent = `${height.toFixed(1)} mm `; draw(); };
  cut.addEventListener("input", slice);
  section.querySelector("#explode").addEventListener("input", (e) => { pose(e.target.value / 60); draw(); });
  section.querySelector("#home").addEventListener("click", home);
  const ray = new Raycaster(), mouse = new Vector2();
  const under = (event) => {
    const box = canvas.getBoundingClientRect();
    mouse.set((event.clientX - box.left) / box.width * 2 - 1, 1 - (event.clientY - box.top) / box.height * 2);
    ray.setFromCamera(mouse, camera);
    const hit = ray.intersectObjects(instanced, false).find((h) => h.point.z <= knife.constant);
    return hit && { mesh: hit.object.userData.mesh, copy: hit.object.userData.mesh.copies[hit.instanceId] };
  };
  let waiting = 0;
  const tell = (found) => { hover.textContent = found ? `${found.mesh.name}${found.mesh.order ? `, order ${found.mesh.order}` : ""}, copy ${found.copy.copy}, from ${found.copy.low_mm.toFixed(1)} to ${found.copy.top_mm.toFixed(1)} mm` : HINT; };
  canvas.addEventListener("pointermove", (event) => { if (event.buttons || performance.now() < waiting) return; const began = performance.now();
    const found = under(event); waiting = performance.now() + 2 * (performance.now() - began); tell(found); });
  let down = null;
  canvas.addEventListener("pointerdown", (e) => { down = [e.clientX, e.clientY]; });
  canvas.addEventListener("click", (e) => { if (down && Math.hypot(e.clientX - down[0], e.clientY - down[1]) > 4) return; const found = under(e); tell(found); marked = found && marked !== found.mesh.part ? found.mesh.part : null; paint(); draw(); });
  canvas.addEventListener("keydown", (e) => {
    const arm = camera.position.clone().sub(controls.target), up = new Vector3(0, 0, 1);
    if (e.key === "ArrowLeft" || e.key === "ArrowRight") arm.applyAxisAngle(up, e.key === "ArrowLeft" ? -0.15 : 0.15);
    else if (e.key === "ArrowUp" || e.key === "ArrowDown") arm.z += (e.key === "ArrowUp" ? 0.1 : -0.1) * arm.length();
    else if (e.key === "+" || e.key === "-") arm.multiplyScalar(e.key === "+" ? 0.9 : 1.1);
    else return;
    e.preventDefault(); camera.position.copy(controls.target).add(arm); controls.update(); draw();
  });
  if (data.missing_copies > 0) {
    const gone = document.createElement("p"), all = section.dataset.copies;
    gone.className = "bad"; gone.textContent = `${data.missing_copies} of ${all} ${all === "1" ? "copy is" : "copies are"} not shown: the originals are no longer kept.`;
    section.prepend(gone);
  }
  theme(); pose(0); paint(); slice(); fit(); home();
}

if (section) load(section.dataset.build).then(show).catch((error) => { section.querySelector("#hover").textContent = `No 3D view: ${error.message}.`; });
