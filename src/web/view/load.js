// Reads the scene: each mesh once, with the poses of its copies (web/scene.rs describes the format).

// A report contains its scene; a page fetches it from the server.
async function fetched(build) {
  const inside = document.querySelector("#scene");
  if (inside) return Uint8Array.from(atob(inside.textContent), (letter) => letter.charCodeAt(0)).buffer;
  const answer = await fetch(`/builds/${build}/scene`);
  if (!answer.ok) throw new Error(`the server answers ${answer.status}`);
  return answer.arrayBuffer();
}

export async function load(build) {
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
