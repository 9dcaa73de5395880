//! Converts numbers to bytes and back.

/// Writes numbers one after the other, least significant byte first.
#[derive(Default)]
pub(crate) struct ByteWriter(pub(crate) Vec<u8>);

impl ByteWriter {
    pub(crate) fn write_u32(&mut self, value: u32) {
        self.0.extend(value.to_le_bytes());
    }

    pub(crate) fn write_f32s(&mut self, values: &[f32]) {
        values.iter().for_each(|v| self.0.extend(v.to_le_bytes()));
    }

    pub(crate) fn write_f64s(&mut self, values: &[f64]) {
        values.iter().for_each(|v| self.0.extend(v.to_le_bytes()));
    }
}

/// Reads the numbers; `None` when there are too few bytes or a number is not finite.
pub(crate) struct ByteReader<'a>(pub(crate) &'a [u8]);

impl<'a> ByteReader<'a> {
    pub(crate) fn read_bytes(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    pub(crate) fn read_u32(&mut self) -> Option<u32> {
        Some(u32::from_le_bytes(self.read_bytes(4)?.try_into().ok()?))
    }

    pub(crate) fn read_f32s<const N: usize>(&mut self) -> Option<[f32; N]> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = f32::from_le_bytes(self.read_bytes(4)?.try_into().ok()?);
        }
        values.iter().all(|v| v.is_finite()).then_some(values)
    }

    pub(crate) fn read_f64s<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = f64::from_le_bytes(self.read_bytes(8)?.try_into().ok()?);
        }
        values.iter().all(|v| v.is_finite()).then_some(values)
    }
}
