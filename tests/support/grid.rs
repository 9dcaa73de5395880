//! Parts of a known number of bytes.

/// A box of a given size as a binary STL, each face divided into squares: 84 + 600 `squares`^2 bytes.
pub fn gridded_box(size_mm: [f64; 3], squares: usize) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((12 * squares as u32 * squares as u32).to_le_bytes());
    for face in 0..6 {
        let (axis, is_far) = (face / 2, face % 2 == 1);
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let corner = |i: usize, j: usize| {
            let mut at = [0.0; 3];
            at[axis] = if is_far { size_mm[axis] } else { 0.0 };
            at[u] = size_mm[u] * i as f64 / squares as f64;
            at[v] = size_mm[v] * j as f64 / squares as f64;
            at
        };
        for (i, j) in (0..squares).flat_map(|i| (0..squares).map(move |j| (i, j))) {
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            for [p, q, r] in [[a, b, c], [a, c, d]] {
                bytes.extend([0; 12]);
                let turned = if is_far { [p, q, r] } else { [p, r, q] };
                turned.iter().flatten().for_each(|mm| bytes.extend((*mm as f32).to_le_bytes()));
                bytes.extend([0; 2]);
            }
        }
    }
    bytes
}
