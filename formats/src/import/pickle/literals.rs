//! The instructions that push a value of their own.

use super::opcodes as op;
use super::source::Source;
use super::value::Value;
use crate::import::ImportError;

/// The value that an instruction pushes; `None` for instructions that do something else.
pub(super) fn literal<'a>(
    opcode: u8,
    source: &mut Source<'a>,
) -> Result<Option<Value<'a>>, ImportError> {
    Ok(Some(match opcode {
        op::NONE => Value::None,
        op::NEWTRUE => Value::Bool(true),
        op::NEWFALSE => Value::Bool(false),
        op::BININT => Value::Int(i32::from_le_bytes(source.array()?).into()),
        op::BININT1 => Value::Int(source.byte()?.into()),
        op::BININT2 => Value::Int(u16::from_le_bytes(source.array()?).into()),
        op::LONG1 => long(source.counted_by_u8()?),
        op::LONG4 => long(source.counted_by_u32()?),
        op::BINFLOAT => Value::Float(f64::from_be_bytes(source.array()?)),
        op::INT | op::LONG => {
            let line = source.line()?;
            decimal(line).ok_or_else(|| source.expected("a decimal number"))?
        }
        op::FLOAT => {
            let number = source.line()?.parse();
            Value::Float(number.map_err(|_| source.expected("a decimal number"))?)
        }
        op::BINUNICODE => Value::Text(source.counted_by_u32().and_then(|b| source.text(b))?),
        op::SHORT_BINUNICODE => Value::Text(source.counted_by_u8().and_then(|b| source.text(b))?),
        op::BINUNICODE8 => Value::Text(source.counted_by_u64().and_then(|b| source.text(b))?),
        op::UNICODE => {
            let line = source.line()?;
            plain(line).ok_or_else(|| source.expected("a text without escapes"))?
        }
        op::STRING => {
            let line = source.line()?;
            let inside =
                ['\'', '"'].iter().find_map(|&quote| line.strip_prefix(quote)?.strip_suffix(quote));
            let expected = || source.expected("a quoted text without escapes");
            inside.and_then(plain).ok_or_else(expected)?
        }
        op::BINSTRING => string(source.counted_by_u32()?),
        op::SHORT_BINSTRING => string(source.counted_by_u8()?),
        op::BINBYTES => Value::Bytes(source.counted_by_u32()?),
        op::SHORT_BINBYTES => Value::Bytes(source.counted_by_u8()?),
        op::BINBYTES8 | op::BYTEARRAY8 => Value::Bytes(source.counted_by_u64()?),
        _ => return Ok(None),
    }))
}

/// A two's complement number of any length; beyond 64 bits the nearest float or so.
fn long(bytes: &[u8]) -> Value<'static> {
    let is_negative = bytes.last().is_some_and(|byte| byte & 0x80 != 0);
    if bytes.len() <= 8 {
        let mut padded = [if is_negative { 0xff } else { 0 }; 8];
        padded[..bytes.len()].copy_from_slice(bytes);
        return Value::Int(i64::from_le_bytes(padded));
    }
    let start = if is_negative { -1.0 } else { 0.0 };
    Value::Float(bytes.iter().rev().fold(start, |sum, byte| sum * 256.0 + f64::from(*byte)))
}

/// `12`, `12L`, and the truth values `00` and `01` of old.
fn decimal(line: &str) -> Option<Value<'static>> {
    match line {
        "00" => return Some(Value::Bool(false)),
        "01" => return Some(Value::Bool(true)),
        _ => {}
    }
    let digits = line.strip_suffix('L').unwrap_or(line);
    digits.parse().map(Value::Int).or_else(|_| digits.parse().map(Value::Float)).ok()
}

fn plain(text: &str) -> Option<Value<'_>> {
    (!text.contains('\\')).then_some(Value::Text(text))
}

/// Python 2 knew one type for texts and for bytes.
fn string(bytes: &[u8]) -> Value<'_> {
    core::str::from_utf8(bytes).map_or(Value::Bytes(bytes), Value::Text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_of_any_length() {
        let number = |bytes: &[u8]| match long(bytes) {
            Value::Int(number) => number as f64,
            Value::Float(number) => number,
            _ => f64::NAN,
        };
        assert_eq!(number(&[]), 0.0);
        assert_eq!(number(&[0xff]), -1.0);
        assert_eq!(number(&[0xff, 0]), 255.0);
        assert_eq!(number(&[0, 0, 0, 0, 0, 0, 0, 0x80]), -(2_f64.powi(63)));
        assert_eq!(number(&[0, 0, 0, 0, 0, 0, 0, 0x80, 0]), 2_f64.powi(63));
        assert_eq!(number(&[0, 0, 0, 0, 0, 0, 0, 0, 0xff]), -(2_f64.powi(64)));
    }

    #[test]
    fn texts_of_protocol_0() {
        fn value(text: &str) -> Result<Option<Value<'_>>, ImportError> {
            let mut source = Source::new(text.as_bytes(), 0);
            let opcode = source.byte()?;
            literal(opcode, &mut source)
        }
        assert!(matches!(value("I01\n"), Ok(Some(Value::Bool(true)))));
        assert!(matches!(value("I-12\n"), Ok(Some(Value::Int(-12)))));
        assert!(matches!(value("L12L\n"), Ok(Some(Value::Int(12)))));
        assert!(matches!(value("F0.5\n"), Ok(Some(Value::Float(0.5)))));
        assert!(matches!(value("S'a b'\n"), Ok(Some(Value::Text("a b")))));
        assert!(matches!(value("Va b\n"), Ok(Some(Value::Text("a b")))));
        assert!(value("S'a\\n'\n").is_err() && value("S'a\n").is_err() && value("Ix\n").is_err());
    }
}
