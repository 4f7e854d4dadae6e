//! The text of a program: declarations in any order.

use alloc::string::String;
use core::fmt::{self, Write};

/// A program that is being written. No function is inlined: pages download what calls them.
#[derive(Debug, Default)]
pub(super) struct Text(String);

/// Adds a line to a [`Text`].
macro_rules! line {
    ($text:expr, $($format:tt)*) => {
        $text.line(format_args!($($format)*))
    };
}
pub(super) use line;

impl Text {
    pub(super) fn into_string(self) -> String {
        self.0
    }

    /// Adds a file.
    #[inline(never)]
    pub(super) fn file(&mut self, file: &str) {
        self.0.push_str(file);
    }

    #[inline(never)]
    pub(super) fn line(&mut self, line: fmt::Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.0.write_fmt(line);
        self.file("\n");
    }

    #[inline(never)]
    pub(super) fn whole(&mut self, name: &str, value: u32) {
        line!(self, "const {name} = {value}u;");
    }

    pub(super) fn flag(&mut self, name: &str, value: bool) {
        line!(self, "const {name} = {value};");
    }

    #[inline(never)]
    pub(super) fn number(&mut self, name: &str, value: f32) {
        line!(self, "const {name} = {};", Number(value));
    }

    #[cfg(feature = "ndc")]
    pub(super) fn pair(&mut self, name: &str, pair: [f32; 2]) {
        let [x, y] = pair.map(Number);
        line!(self, "const {name} = vec2f({x}, {y});");
    }

    #[inline(never)]
    pub(super) fn point(&mut self, name: &str, point: [f32; 3]) {
        let [x, y, z] = point.map(Number);
        line!(self, "const {name} = vec3f({x}, {y}, {z});");
    }
}

/// A finite number, to the bit: in hexadecimal digits, so that no decimal ones are needed.
pub(super) struct Number(pub(super) f32);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (bits, sign) = (self.0.to_bits(), if self.0.is_sign_negative() { "-" } else { "" });
        let exponent = (bits >> 23) & 0xff;
        // 23 bits of fraction, after the one that is always there; none of zero, and of what
        // is too small for a GPU to tell from it.
        let digits = if exponent == 0 { 0 } else { (bits & 0x7f_ffff) | 0x80_0000 };
        let (minus, by) = if exponent < 150 { ("-", 150 - exponent) } else { ("", exponent - 150) };
        write!(f, "{sign}0x{digits:x}p{minus}{by}f")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_as_they_are_declared() {
        let mut text = Text::default();
        text.whole("N", 3);
        text.flag("IS", true);
        text.number("SMALL", -1e-7);
        text.number("THIRD", 1.0 / 3.0);
        text.point("AT", [0.0, 1.0, 2.5]);
        let expected = "const N = 3u;\nconst IS = true;\nconst SMALL = -0xd6bf95p-47f;\n\
                        const THIRD = 0xaaaaabp-25f;\n\
                        const AT = vec3f(0x0p-150f, 0x800000p-23f, 0xa00000p-22f);\n";
        assert_eq!(text.into_string(), expected);
    }
}
