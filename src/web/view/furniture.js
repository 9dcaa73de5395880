// What stands around the parts: the base with its grid, the walls, a scale of heights, and which side is the front.
import { Box3, Box3Helper, BufferAttribute, BufferGeometry, CanvasTexture, Group, LineBasicMaterial, LineSegments, Sprite, SpriteMaterial, Vector3 } from "three";

/** Distance of the lines of the base and of the marks of the scale, mm: about six to the longest side, a round number. */
export function roundStep(length) {
  const power = 10 ** Math.floor(Math.log10(length / 6));
  return [1, 2, 5, 10].map((n) => n * power).find((step) => length / step <= 8);
}

function lines(points, material) {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
  return new LineSegments(geometry, material);
}

/** A text that faces the camera, `high` mm tall. */
function label(text, high, colour) {
  const canvas = document.createElement("canvas"), context = canvas.getContext("2d"), font = "600 48px system-ui, sans-serif";
  context.font = font;
  canvas.width = Math.ceil(context.measureText(text).width) + 8; canvas.height = 60;
  context.font = font; context.fillStyle = colour; context.textBaseline = "middle";
  context.fillText(text, 4, 32);
  const sprite = new Sprite(new SpriteMaterial({ map: new CanvasTexture(canvas), depthTest: false, transparent: true }));
  sprite.scale.set(high * canvas.width / canvas.height, high, 1);
  return sprite;
}

/** Everything around the parts: lines in one colour, texts in another. `frontWord` says which side is the front. */
export function furniture([x, y, z], heightMm, colour, ink, frontWord) {
  const group = new Group(), faint = new LineBasicMaterial({ color: colour, transparent: true, opacity: 0.35 }), plain = new LineBasicMaterial({ color: colour });
  const step = roundStep(Math.max(x, y)), rise = roundStep(z), high = Math.max(x, y) / 22, base = [];
  for (let at = 0; at <= x; at += step) base.push(at, 0, 0, at, y, 0);
  for (let at = 0; at <= y; at += step) base.push(0, at, 0, x, at, 0);
  const box = new Box3Helper(new Box3(new Vector3(), new Vector3(x, y, z)));
  box.material = plain;
  const marks = [], scale = new Group(), front = label(frontWord, 1.5 * high, ink);
  for (let at = 0; at <= z + 1e-6; at += rise) {
    const text = label(`${at} mm`, high, ink);
    marks.push(0, 0, at, high, 0, at);
    text.position.set(3.2 * high, 0, at);
    scale.add(text);
  }
  front.position.set(x / 2, -1.6 * high, 0);
  scale.add(lines(marks, plain));
  group.add(lines(base, faint), box, scale, front);
  // The scale stands at the edge that is seen on the right of all, and points away from the parts: it lies over none of them.
  const middle = new Vector3(x / 2, y / 2, z / 2), corners = [[0, 0], [x, 0], [x, y], [0, y]];
  group.userData.turn = (camera) => {
    const right = ([cx, cy]) => new Vector3(cx, cy, middle.z).project(camera).x;
    const [cx, cy] = corners.reduce((best, corner) => (right(corner) > right(best) ? corner : best));
    scale.position.set(cx, cy, 0);
    scale.rotation.z = Math.atan2(cy - middle.y, cx - middle.x);
  };
  if (heightMm) {
    const top = [[0, 0], [x, 0], [x, y], [0, y]];
    group.add(lines(top.flatMap((corner, n) => [...corner, heightMm, ...top[(n + 1) % 4], heightMm]), faint));
  }
  return group;
}
