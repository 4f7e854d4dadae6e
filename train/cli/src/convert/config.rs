//! The config that a program writes beside its checkpoints.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use yaml_rust2::parser::{Event, Parser};

use pocketnerf_train::convert::{ConvertError, Settings};

/// File names, the most informative first.
const NAMES: [&str; 3] = ["config.yml", "args.txt", "config.txt"];
/// Most bytes of a config.
const MOST: u64 = 1 << 16;

/// The config in the checkpoint's folder: its file and its settings.
///
/// # Errors
/// [`ConvertError::Config`] for a file that cannot be read, and for choices that a model
/// cannot express.
pub fn beside(checkpoint: &Path) -> Result<Option<(PathBuf, Settings)>, ConvertError> {
    let folder = checkpoint.parent().unwrap_or(Path::new(""));
    let Some(file) = NAMES.map(|name| folder.join(name)).into_iter().find(|f| f.is_file()) else {
        return Ok(None);
    };
    let refuse = |problem: String| ConvertError::Config { file: file.clone(), problem };
    let text = text(&file).map_err(refuse)?;
    let is_yaml = file.extension().is_some_and(|extension| extension == "yml");
    let settings = if is_yaml { of_yaml(&text) } else { Values(lines(&text)).of_arguments() };
    settings.map(|settings| Some((file.clone(), settings))).map_err(refuse)
}

/// The text of a short file.
pub(super) fn text(file: &Path) -> Result<String, String> {
    let length = std::fs::metadata(file).map_err(|error| error.to_string())?.len();
    if length > MOST {
        return Err(format!("{length} bytes, at most {MOST} are read"));
    }
    std::fs::read_to_string(file).map_err(|error| error.to_string())
}

/// Lines of `key = value`; `#` starts a comment.
fn lines(text: &str) -> BTreeMap<String, String> {
    let pairs = text.lines().filter_map(|line| {
        let line = line.split('#').next().unwrap_or(line);
        let (key, value) = line.split_once('=')?;
        Some((key.trim().to_owned(), value.trim().to_owned()))
    });
    pairs.collect()
}

fn of_yaml(text: &str) -> Result<Settings, String> {
    Values::of_yaml(text)?.of_tree()
}

impl Values {
    /// The values of a YAML tree, by their keys joined with dots.
    pub(super) fn of_yaml(text: &str) -> Result<Self, String> {
        let mut scalars = Scalars::default();
        let mut parser = Parser::new_from_str(text);
        // One by one: the parser's own loop recurses for every level of nesting.
        loop {
            let (event, _) = parser.next_token().map_err(|error| error.to_string())?;
            if event == Event::StreamEnd {
                return Ok(Self(scalars.found));
            }
            scalars.take(event);
        }
    }
}

/// Values by their keys, those of nested mappings joined with dots. Lists are ignored and
/// aliases are not followed, so a text cannot grow.
#[derive(Default)]
struct Scalars {
    /// Of each mapping that is open, the key whose value comes next; `None` in a list.
    open: Vec<Open>,
    found: BTreeMap<String, String>,
}

enum Open {
    Mapping(Option<String>),
    List,
}

impl Scalars {
    fn take(&mut self, event: Event) {
        match event {
            Event::Scalar(text, ..) => self.scalar(text),
            Event::Alias(_) => self.end_value(),
            Event::MappingStart(..) => self.open.push(Open::Mapping(None)),
            Event::SequenceStart(..) => self.open.push(Open::List),
            Event::MappingEnd | Event::SequenceEnd => {
                self.open.pop();
                self.end_value();
            }
            _ => {}
        }
    }

    fn scalar(&mut self, text: String) {
        match self.open.last_mut() {
            Some(Open::Mapping(key @ None)) => *key = Some(text),
            Some(Open::Mapping(Some(_))) => {
                let keys = self.open.iter().map(|open| match open {
                    Open::Mapping(Some(key)) => key,
                    _ => "",
                });
                self.found.insert(keys.collect::<Vec<_>>().join("."), text);
                self.end_value();
            }
            _ => {}
        }
    }

    fn end_value(&mut self) {
        if let Some(Open::Mapping(key)) = self.open.last_mut() {
            *key = None;
        }
    }
}

/// The values of a config, by their keys.
pub(super) struct Values(BTreeMap<String, String>);

impl Values {
    pub(super) fn text(&self, key: &str) -> Option<&str> {
        self.0.get(key).map(String::as_str).filter(|text| *text != "None" && *text != "null")
    }

    pub(super) fn truth(&self, key: &str) -> Result<Option<bool>, String> {
        let Some(text) = self.text(key) else { return Ok(None) };
        match text.to_ascii_lowercase().as_str() {
            "true" | "1" => Ok(Some(true)),
            "false" | "0" => Ok(Some(false)),
            _ => Err(format!("{key} is {text}, expected true or false")),
        }
    }

    pub(super) fn number<T: std::str::FromStr>(&self, key: &str) -> Result<Option<T>, String> {
        let Some(text) = self.text(key) else { return Ok(None) };
        text.parse().map(Some).map_err(|_| format!("{key} is {text}, expected a number"))
    }

    /// krrish94/nerf-pytorch.
    fn of_tree(&self) -> Result<Settings, String> {
        self.refuse("nerf.validation.lindisp", true)?;
        for network in ["coarse", "fine"] {
            for what in ["xyz", "dir"] {
                self.refuse(&format!("models.{network}.log_sampling_{what}"), false)?;
            }
        }
        let white = self.truth("nerf.validation.white_background")?;
        Ok(Settings {
            near: self.number("dataset.near")?,
            far: self.number("dataset.far")?,
            samples: [
                self.number("nerf.validation.num_coarse")?,
                self.number("nerf.validation.num_fine")?,
            ],
            background: white.map(background),
            ndc: self.truth("dataset.no_ndc")?.map(|no| !no),
            ..Settings::default()
        })
    }

    /// bmild/nerf and yenchenlin/nerf-pytorch: the options of their command line. Defaults by
    /// kind of dataset are those of these programs.
    fn of_arguments(&self) -> Result<Settings, String> {
        self.refuse("lindisp", true)?;
        let (blender, llff) = (Some("blender"), Some("llff"));
        let dataset = self.text("dataset_type");
        let ndc = match self.truth("no_ndc")? {
            Some(no) => Some(dataset == llff && !no),
            None => dataset.map(|_| dataset == llff),
        };
        let [near, far] = if dataset == blender { [Some(2.0), Some(6.0)] } else { [None; 2] };
        let white = match self.truth("white_bkgd")? {
            None if dataset.is_some() => Some(false),
            white => white,
        };
        Ok(Settings {
            near,
            far,
            samples: [self.number("N_samples")?, self.number("N_importance")?],
            background: white.map(background),
            ndc,
            ..Settings::default()
        })
    }

    /// Refuses a choice that no model can express.
    fn refuse(&self, key: &str, value: bool) -> Result<(), String> {
        match self.truth(key)? {
            Some(found) if found == value => Err(format!(
                "{key} is {value}: pictures of such a network cannot be made, its samples or \
                 octaves are spread otherwise"
            )),
            _ => Ok(()),
        }
    }
}

fn background(white: bool) -> [f32; 3] {
    if white { [1.0; 3] } else { [0.0; 3] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tree_of_settings() {
        let text = "dataset:\n  near: 2\n  far: 6.5\n  no_ndc: false\n  list: [1, {near: 3}]\n\
                    nerf: {validation: {num_coarse: 64, num_fine: 32, white_background: true}}\n\
                    again: &a {near: 9}\nmore: [*a, *a]\nnear: *a\n";
        let settings = of_yaml(text).unwrap();
        let expected = Settings {
            near: Some(2.0),
            far: Some(6.5),
            samples: [Some(64), Some(32)],
            background: Some([1.0; 3]),
            ndc: Some(true),
            ..Settings::default()
        };
        assert_eq!(settings, expected);
        for (text, problem) in [
            ("nerf: {validation: {lindisp: true}}", "lindisp is true"),
            ("models: {fine: {log_sampling_dir: False}}", "log_sampling_dir is false"),
            ("dataset: {near: two}", "near is two, expected a number"),
            ("dataset: {no_ndc: perhaps}", "expected true or false"),
            ("a: [", "line 2"),
        ] {
            let error = of_yaml(text).unwrap_err();
            assert!(error.contains(problem), "{error}");
        }
    }

    /// As deep as a config may be long: an answer, and soon.
    #[test]
    fn nesting_without_end() {
        let most = MOST as usize;
        for text in ["- ".repeat(most / 2), "[".repeat(most), "{a: ".repeat(most / 4)] {
            let _ = of_yaml(&text);
        }
        let indented: String = (0..300).map(|i| " ".repeat(i) + "a:\n").collect();
        assert_eq!(of_yaml(&indented), Ok(Settings::default()));
    }

    #[test]
    fn lines_of_arguments() {
        let text = "expname = lego # the scene\nN_samples = 64\nN_importance = 128\n\
                    white_bkgd = True\nno_ndc = False\ndataset_type = blender\nft_path = None\n";
        let settings = Values(lines(text)).of_arguments().unwrap();
        assert_eq!((settings.near, settings.far), (Some(2.0), Some(6.0)));
        assert_eq!(settings.samples, [Some(64), Some(128)]);
        assert_eq!((settings.background, settings.ndc), (Some([1.0; 3]), Some(false)));
        let text = "dataset_type = llff\nN_importance = 64\n";
        let settings = Values(lines(text)).of_arguments().unwrap();
        assert_eq!((settings.ndc, settings.background), (Some(true), Some([0.0; 3])));
        assert_eq!((settings.near, settings.samples), (None, [None, Some(64)]));
        assert!(Values(lines("lindisp = True")).of_arguments().is_err());
    }
}
