//! Pickles that want more than tensors need.

use pocketnerf_formats::import::{Checkpoint, ImportError};

use super::counting::most_held;
use super::fixture;
use super::numpy::npy;

/// A `.npy` of objects, whose contents are a pickle.
fn file(pickle: &[u8]) -> Vec<u8> {
    npy("{'descr': '|O', 'fortran_order': False, 'shape': (1,), }", pickle)
}

#[track_caller]
fn refused(pickle: &[u8]) -> String {
    let file = file(pickle);
    let mut message = String::new();
    let held = most_held(|| message = Checkpoint::read(&file).unwrap_err().to_string());
    assert!(held <= (64 << 20) + 4 * file.len(), "{held} bytes held");
    message
}

fn accepted(pickle: &[u8]) {
    Checkpoint::read(&file(pickle)).unwrap();
}

#[test]
fn calls_are_refused_by_name() {
    let calls: [(&[u8], &str); 9] = [
        (b"cposix\nsystem\n(S'true'\ntR.", "posix.system"),
        (b"\x80\x02cbuiltins\neval\nX\x03\0\0\x001+1\x85R.", "builtins.eval"),
        (b"\x80\x04\x8c\x02os\x8c\x06system\x93\x8c\x04true\x85R.", "os.system"),
        (b"(S'true'\nios\nsystem\n.", "os.system"),
        (b"(cos\nsystem\nS'true'\no.", "os.system"),
        (b"\x80\x02csubprocess\nPopen\n)\x81.", "subprocess.Popen"),
        (b"\x80\x04csubprocess\nPopen\n)}\x92.", "subprocess.Popen"),
        // A state that is made by a call, and one that is set on a class.
        (b"\x80\x02cargparse\nNamespace\n)\x81cos\nsystem\nX\0\0\0\0\x85Rb.", "os.system"),
        (b"\x80\x02cos\nsystem\n}b.", "os.system"),
    ];
    for (pickle, name) in calls {
        let expected = format!("the pickle calls {name}, which no tensor needs: refused");
        assert_eq!(refused(pickle), expected);
    }
    let error = Checkpoint::read(&fixture("eval.pt")).unwrap_err();
    assert_eq!(error, ImportError::Call("__builtin__.eval".to_owned()));
}

#[test]
fn a_name_that_is_not_called_is_harmless() {
    accepted(b"cposix\nsystem\n.");
}

#[test]
fn a_name_from_a_file_is_shown_in_one_line() {
    let long = [b"\x80\x02c", &b"a\r\x1b"[..], &[b'b'; 10_000], b"\nf\n)R."].concat();
    let error = refused(&long);
    assert!(error.len() < 300 && error.contains(r"a\r\u{1b}b") && !error.contains('\r'));
}

#[test]
fn unknown_instructions_are_refused() {
    // An extension registered by number, and a reference by text.
    assert_eq!(
        refused(b"\x80\x02\x82\x01."),
        "the pickle's byte 2: instruction 0x82, which no checkpoint needs: refused"
    );
    assert!(refused(b"Pname\n.").contains("instruction 0x50"));
}

#[test]
fn values_below_a_mark_are_out_of_reach() {
    accepted(b"N(t.");
    for pickle in [&b"."[..], b"N(.", b"(.", b"N(0.0.", b"t.", b"N(\x85.", b"K\x01(a.", b"}(Nu."] {
        refused(pickle);
    }
}

/// A billion names from a hundred bytes, by sharing.
#[test]
fn what_is_shared_is_not_multiplied() {
    let mut laughs = b"\x80\x02(K\x00K\x00l".to_vec();
    for _ in 0..60 {
        laughs.extend(b"q\x00(h\x00h\x00l");
    }
    laughs.push(b'.');
    assert!(refused(&laughs).contains("most read"));
    // Without a name at the end, it takes only time.
    let empty = laughs.iter().map(|&byte| if byte == b'K' { b'M' } else { byte });
    let empty: Vec<u8> = empty.collect();
    Checkpoint::read(&file(&empty)).unwrap_err();
    let mut hollow = b"\x80\x02)".to_vec();
    for _ in 0..60 {
        hollow.extend(b"q\x00(h\x00h\x00t");
    }
    hollow.push(b'.');
    assert!(refused(&hollow).contains("bytes of memory"));
}

#[test]
fn what_holds_itself_is_refused() {
    let expected = "levels of the pickle, or it holds itself: more than 64, the most read";
    assert_eq!(refused(b"\x80\x02]q\x00h\x00a."), expected);
    assert_eq!(refused(b"\x80\x02}q\x00X\x01\0\0\0ah\x00s."), expected);
}

/// Neither walking nor dropping follows the depth.
#[test]
fn depth_is_bounded() {
    let deep = [&b"N"[..], &[0x85; 100_000], b"."].concat();
    assert!(refused(&deep).contains("levels of the pickle"));
    let unused = [&b"N"[..], &[0x85; 100_000], b"0N."].concat();
    accepted(&unused);
    let deeper = [&b"N"[..], &[0x85; 1_000_000], b"."].concat();
    assert!(refused(&deeper).contains("bytes of memory"));
    let marks = [&[b'('; 1_000_000][..], b"."].concat();
    refused(&marks);
}

/// Many copies of a long key, and many copies of a long list.
#[test]
fn copies_are_counted() {
    let key = vec![b'k'; 1 << 20];
    let mut pickle = b"\x80\x02}(X\x00\x00\x10\x00".to_vec();
    pickle.extend(&key);
    pickle.extend(b"q\x00)");
    for _ in 0..100_000 {
        pickle.extend(b"h\x00)");
    }
    pickle.extend(b"u.");
    assert!(refused(&pickle).contains("bytes of memory"));

    let mut pickle = b"\x80\x02(".to_vec();
    pickle.extend([b'N'; 100_000]);
    pickle.extend(b"tq\x000");
    for _ in 0..100_000 {
        pickle.extend(b"c__builtin__\nlist\nh\x00\x85R");
    }
    pickle.push(b'.');
    assert!(refused(&pickle).contains("bytes of memory"));
}

/// Short instructions that make large things, and a large thing with many names.
#[test]
fn memory_is_bounded() {
    for made in [&b"}"[..], b"]", b")", b"(", b"N", b"\x940", b"cargparse\nNamespace\n)\x81"] {
        let pickle = [&b"\x80\x04N"[..], &made.repeat(2_000_000), b"."].concat();
        refused(&pickle);
    }
    let array: &[u8] =
        b"\x80\x04cnumpy.core.numeric\n_frombuffer\n(C\x01\x07cnumpy\ndtype\n\x8c\x02u1\x85R(";
    let mut pickle = array.to_vec();
    pickle.extend(b"K\x01".repeat(64));
    pickle.extend(b"t\x8c\x01CtRq\x000(");
    pickle.extend(b"h\x00".repeat(900_000));
    pickle.extend(b"l.");
    assert!(refused(&pickle).contains("bytes of memory"));
}

#[test]
fn lengths_beyond_the_file_are_refused() {
    let cut_off = "the pickle ends too early: the file is cut off";
    assert_eq!(refused(b"\x80\x04\x8d\xff\xff\xff\xff\xff\xff\xff\xff."), cut_off);
    assert_eq!(refused(b"\x80\x05\x96\xff\xff\xff\xff\xff\xff\xff\x7f."), cut_off);
    assert_eq!(refused(b"\x80\x02X\xff\xff\xff\xff."), cut_off);
    assert_eq!(refused(b"\x80\x02\x8b\xff\xff\xff\xff."), cut_off);
}

#[test]
fn other_files_are_no_checkpoints() {
    let error = Checkpoint::read(b"\x89PNG\r\n\x1a\nand more").unwrap_err();
    assert_eq!(
        error.to_string(),
        "not a checkpoint that can be read: begins with 89 50 4e 47 0d 0a 1a 0a, expected what \
         torch.save, numpy.save, safetensors or instant-ngp write"
    );
    for bytes in [&b""[..], b"PK", b"\x80\x02N.", &[0; 100]] {
        let error = Checkpoint::read(bytes).unwrap_err();
        assert!(matches!(error, ImportError::NotCheckpoint { .. }), "{error}");
    }
}
