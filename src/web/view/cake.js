// The parts of a build: each mesh drawn twice, solid for the copies that are chosen (all, if none is), and as a ghost for the rest.
import { BufferAttribute, BufferGeometry, InstancedMesh, Matrix4, MeshBasicMaterial, MeshLambertMaterial, Quaternion, Vector3 } from "three";
import { toColor } from "./palette.js";

const GHOST_OPACITY = 0.07;

/** A solid surface; where it is cut, the inner sides are plain, as if the part were full. */
function solidMaterial(knife) {
  const material = new MeshLambertMaterial({ flatShading: true, clippingPlanes: [knife], side: 2 });
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace("#include <opaque_fragment>", "if (!gl_FrontFacing) outgoingLight = 0.8 * diffuseColor.rgb;\n#include <opaque_fragment>");
  };
  return material;
}

export class Cake {
  constructor(data, knife) {
    this.data = data;
    this.explode = 0;
    this.pieces = data.meshes.map((mesh) => {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new BufferAttribute(mesh.positions, 3));
      geometry.setIndex(new BufferAttribute(mesh.indices, 1));
      const ghostly = new MeshBasicMaterial({ clippingPlanes: [knife], transparent: true, opacity: GHOST_OPACITY, depthWrite: false });
      const [solid, ghost] = [solidMaterial(knife), ghostly].map((material) => new InstancedMesh(geometry, material, mesh.copies.length));
      const piece = { mesh, solid, ghost };
      for (const drawn of [solid, ghost]) drawn.userData = { piece, copies: [] };
      return piece;
    });
  }

  get objects() { return this.pieces.flatMap(({ solid, ghost }) => [solid, ghost]); }
  get count() { return this.objects.reduce((sum, drawn) => sum + drawn.count, 0); }

  /** Places every copy: `isChosen(mesh)` says whether it is solid, `colour(mesh, copy)` in which colour. */
  arrange(isChosen, colour, ghostColour) {
    const [x, y] = this.data.volume_mm, turn = new Quaternion(), one = new Vector3(1, 1, 1), place = new Vector3(), out = new Vector3(), matrix = new Matrix4();
    for (const { mesh, solid, ghost } of this.pieces) {
      const drawn = isChosen(mesh) ? solid : ghost;
      for (const each of [solid, ghost]) { each.count = each === drawn ? mesh.copies.length : 0; each.userData.copies = each === drawn ? mesh.copies : []; each.visible = each === drawn; }
      mesh.copies.forEach((copy, at) => {
        place.fromArray(copy.translation_mm);
        out.set(place.x - x / 2, place.y - y / 2, (copy.low_mm + copy.top_mm) / 2).multiplyScalar(this.explode);
        turn.fromArray(copy.rotation);
        drawn.setMatrixAt(at, matrix.compose(place.add(out), turn, one));
        if (drawn === solid) drawn.setColorAt(at, toColor(colour(mesh, copy)));
      });
      ghost.material.color.set(ghostColour);
      drawn.instanceMatrix.needsUpdate = true;
      if (drawn.instanceColor) drawn.instanceColor.needsUpdate = true;
      drawn.computeBoundingSphere();
    }
  }

  /** The copy that a ray meets first, below the knife; a solid one before a ghost. */
  hit(ray, knife) {
    const solids = this.pieces.map(({ solid }) => solid).filter((drawn) => drawn.count > 0), ghosts = this.pieces.map(({ ghost }) => ghost).filter((drawn) => drawn.count > 0);
    for (const objects of [solids, ghosts]) {
      const hit = ray.intersectObjects(objects, false).find((h) => h.point.z <= knife.constant);
      if (hit) return { mesh: hit.object.userData.piece.mesh, copy: hit.object.userData.copies[hit.instanceId] };
    }
    return null;
  }
}
