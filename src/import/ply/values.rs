//! The values behind the header, one after the other, whatever way they are written.

use super::header::{Encoding, Scalar};
use crate::import::text::{name, number};

/// Takes values from the front of the rest of a file.
#[derive(Clone, Debug)]
pub(super) struct Values<'a> {
    rest: &'a [u8],
    encoding: Encoding,
}

impl<'a> Values<'a> {
    pub(super) fn new(rest: &'a [u8], encoding: Encoding) -> Values<'a> {
        Values { rest, encoding }
    }

    /// How many bytes are left.
    pub(super) fn left(&self) -> u64 {
        self.rest.len() as u64
    }

    /// The next value, or why there is none.
    pub(super) fn next(&mut self, scalar: Scalar) -> Result<f64, String> {
        match self.encoding {
            Encoding::Ascii => self.word(),
            Encoding::Little => self.binary(scalar, false),
            Encoding::Big => self.binary(scalar, true),
        }
    }

    /// The next value as a length. It is checked that there are bytes for as many values.
    pub(super) fn length(&mut self, length: Scalar, item: Scalar) -> Result<u64, String> {
        let value = self.next(length)?;
        if !(value >= 0.0 && value.fract() == 0.0 && value <= f64::from(u32::MAX)) {
            return Err(format!("{value} is no length of a list"));
        }
        // Exact: a whole number in u32.
        let count = value as u64;
        let size = if self.encoding == Encoding::Ascii { 1 } else { item.size() };
        if count * size > self.left() {
            return Err(format!("a list of {count}, and there are {} bytes left", self.left()));
        }
        Ok(count)
    }

    /// Passes over `count` values.
    pub(super) fn skip(&mut self, scalar: Scalar, count: u64) -> Result<(), String> {
        if self.encoding == Encoding::Ascii {
            for _ in 0..count {
                self.word()?;
            }
            return Ok(());
        }
        let bytes = usize::try_from(count.saturating_mul(scalar.size())).unwrap_or(usize::MAX);
        self.rest = self.rest.get(bytes..).ok_or_else(|| "the file ends".to_owned())?;
        Ok(())
    }

    fn word(&mut self) -> Result<f64, String> {
        let text = self.rest.trim_ascii_start();
        if text.is_empty() {
            return Err("the file ends".to_owned());
        }
        let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(text.len());
        let (word, rest) = text.split_at(end);
        self.rest = rest;
        number(word).ok_or_else(|| format!("'{}' is no number", name(word)))
    }

    fn binary(&mut self, scalar: Scalar, big: bool) -> Result<f64, String> {
        fn take<const N: usize>(rest: &mut &[u8], big: bool) -> Result<[u8; N], String> {
            let (bytes, after) = rest.split_first_chunk::<N>().ok_or_else(|| "the file ends".to_owned())?;
            *rest = after;
            let mut bytes = *bytes;
            if big {
                bytes.reverse();
            }
            Ok(bytes)
        }
        let rest = &mut self.rest;
        Ok(match scalar {
            Scalar::I8 => i8::from_le_bytes(take(rest, big)?).into(),
            Scalar::U8 => u8::from_le_bytes(take(rest, big)?).into(),
            Scalar::I16 => i16::from_le_bytes(take(rest, big)?).into(),
            Scalar::U16 => u16::from_le_bytes(take(rest, big)?).into(),
            Scalar::I32 => i32::from_le_bytes(take(rest, big)?).into(),
            Scalar::U32 => u32::from_le_bytes(take(rest, big)?).into(),
            Scalar::F32 => f32::from_le_bytes(take(rest, big)?).into(),
            Scalar::F64 => f64::from_le_bytes(take(rest, big)?),
        })
    }
}
