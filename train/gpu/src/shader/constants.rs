//! Constants of a program.

use alloc::format;
use alloc::string::{String, ToString};

use super::network::write_line;

/// Lines that declare constants.
#[derive(Debug, Default)]
pub(super) struct Constants(String);

impl Constants {
    pub(super) fn text(&self) -> &str {
        &self.0
    }

    fn add(&mut self, name: &str, value: &str) {
        write_line(&mut self.0, &format!("const {name} = {value};"));
    }

    pub(super) fn whole(&mut self, name: &str, value: u32) {
        self.add(name, &format!("{value}u"));
    }

    pub(super) fn flag(&mut self, name: &str, value: bool) {
        self.add(name, &value.to_string());
    }

    pub(super) fn number(&mut self, name: &str, value: f32) {
        self.add(name, &number(value));
    }

    #[cfg(feature = "ndc")]
    pub(super) fn pair(&mut self, name: &str, [x, y]: [f32; 2]) {
        self.add(name, &format!("vec2f({}, {})", number(x), number(y)));
    }

    pub(super) fn point(&mut self, name: &str, [x, y, z]: [f32; 3]) {
        self.add(name, &format!("vec3f({}, {}, {})", number(x), number(y), number(z)));
    }
}

/// A finite number, to the bit: in hexadecimal digits, so that no decimal ones are needed.
pub(super) fn number(value: f32) -> String {
    let (bits, sign) = (value.to_bits(), if value.is_sign_negative() { "-" } else { "" });
    // 23 bits of fraction are six digits and one bit less.
    let (exponent, digits) = (bits >> 23 & 0xff, (bits & 0x7f_ffff) << 1);
    match exponent {
        // Zero, and what is too small for a GPU to tell from it.
        0 => format!("{sign}0.0f"),
        _ => format!("{sign}0x1.{digits:06x}p{}f", exponent as i32 - 127),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_as_they_are_declared() {
        let mut constants = Constants::default();
        constants.whole("N", 3);
        constants.number("SMALL", -1e-7);
        constants.number("THIRD", 1.0 / 3.0);
        constants.point("AT", [0.0, 1.0, 2.5]);
        let expected = "const N = 3u;\nconst SMALL = -0x1.ad7f2ap-24f;\nconst THIRD = 0x1.555556p-2f;\n\
                        const AT = vec3f(0.0f, 0x1.000000p0f, 0x1.400000p1f);\n";
        assert_eq!(constants.text(), expected);
    }
}
