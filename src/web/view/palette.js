// The colours of the 3D view and of the list beside it, which the colour-blind can tell apart: Okabe and Ito's for kinds, Cividis for what
// has an order. Those of kinds are the colours of the pictures (build-file/src/shade.rs).
import { Color } from "three";

const KINDS = [[0, 114, 178], [230, 159, 0], [0, 158, 115], [204, 121, 167], [86, 180, 233], [213, 94, 0], [240, 228, 66]];
// Cividis (Nunez, Anderton, Renslow 2018), from low to high.
const SCALE = [[0, 34, 78], [53, 69, 108], [102, 105, 112], [148, 142, 119], [201, 184, 102], [254, 232, 56]];
const NONE = [127, 127, 127];
// The kinds whose colours bins have (break_out/bins.rs): all can tell them apart.
const BINS = [0, 2, 6, 17, 4, 19, 5, 14, 9, 13];
/** Share of white in the colour of a sibling of the copy that was tapped. */
const PALE = 0.6;

/** The colour of the n-th kind: plain, lighter and darker. */
export function kindColour(number) {
  const shade = [(c) => c, (c) => c + 0.45 * (255 - c), (c) => 0.62 * c][(number / KINDS.length | 0) % 3];
  return css(KINDS[number % KINDS.length].map(shade));
}

/** The colour of the n-th order, which is that of its bin. */
export const orderColour = (number) => kindColour(BINS[number % BINS.length]);

/** A colour for siblings of the copy that was tapped. */
export const pale = (colour) => `#${toColor(colour).lerp(toColor("#fff"), PALE).getHexString()}`;

/** The colour of a share from 0 to 1; grey where there is none. */
export function scaleColour(share) {
  if (share === null || Number.isNaN(share)) return css(NONE);
  const at = Math.min(Math.max(share, 0), 1) * (SCALE.length - 1), low = Math.min(Math.floor(at), SCALE.length - 2);
  return css(SCALE[low].map((c, n) => c + (at - low) * (SCALE[low + 1][n] - c)));
}

export const toColor = (text) => new Color(text);
const css = (rgb) => `rgb(${rgb.map(Math.round).join(",")})`;
