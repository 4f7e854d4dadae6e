//! Programs that act as COLMAP and ffmpeg, photographs, and a place to work.

use std::os::unix::fs::PermissionsExt;
use std::process::{Command, Output};

use serde_json::Value;

use crate::place::{Place, text};

/// Writes down what it is asked, and makes the files that COLMAP makes: a model of the photographs
/// in `images`, text files as COLMAP writes them.
pub(super) const COLMAP: &str = r#"#!/bin/sh
PATH=/usr/bin:/bin
case "$1 $2" in
*-version*|help*) echo "COLMAP 3.8 without CUDA"; exit 0 ;;
*--help) echo "  --SiftExtraction.use_gpu arg (=1)
  --SiftMatching.use_gpu arg
  --Mapper.num_threads arg"; exit 0 ;;
esac
echo "$@" >> "$CALLS"
if [ "$1" = "$FAIL" ]; then echo "working"; echo "ERROR: no more disk" >&2; exit 3; fi
out=; images=; database=
while [ $# -gt 0 ]; do
  case "$1" in
  --output_path) out=$2 ;;
  --image_path) images=$2 ;;
  --database_path) database=$2 ;;
  esac
  shift
done
[ -z "$SLOW" ] || { echo started > "$SLOW"; sleep 4; }
echo x >> "$database"
if [ -n "$out" ] && [ -z "$NONE" ]; then
  for model in $MODELS; do
    dir="$out/${model%:*}"; n=${model#*:}
    mkdir "$dir"
    echo "1 PINHOLE 16 16 20 20 8 8" > "$dir/cameras.txt"
    : > "$dir/points3D.txt"
    i=0
    for image in $(ls "$images" | head -n "$n"); do
      i=$((i + 1))
      echo "$i 1 0 0 0 0.$i 0.$((i * i)) 3 1 $image"; echo
    done > "$dir/images.txt"
  done
fi
"#;

pub(super) const FFMPEG: &str = r#"#!/bin/sh
PATH=/usr/bin:/bin
case "$1" in -version) exit 0 ;; esac
echo ffmpeg "$@" >> "$CALLS"
for last; do :; done
i=0
for image in "$FRAMES"/*; do
  i=$((i + 1))
  cp "$image" "$(printf "$last" $i)"
  echo "frame=$i"
done
"#;

pub(super) const FFPROBE: &str = r#"#!/bin/sh
PATH=/usr/bin:/bin
case "$1" in -version) exit 0 ;; esac
echo '{"streams": [{}], "format": {"duration": "4.0"}}'
"#;

/// Programs in a folder, photographs, and a place to work.
pub(super) struct Shop {
    pub(super) place: Place,
}

impl Shop {
    pub(super) fn new(programs: &[(&str, &str)]) -> Self {
        let shop = Self { place: Place::new() };
        for name in ["bin", "photos"] {
            std::fs::create_dir(shop.place.path(name)).unwrap();
        }
        for (name, script) in programs {
            let file = shop.place.path("bin").join(name);
            std::fs::write(&file, script).unwrap();
            std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o755)).unwrap();
        }
        for i in 0..6 {
            let from = shop.place.path(&format!("data/{i}.png"));
            std::fs::copy(from, shop.place.path(&format!("photos/{i}.png"))).unwrap();
        }
        shop
    }

    pub(super) fn command(&self, options: &str) -> Command {
        let mut command = self.place.command(options);
        // No other programs.
        command.env("PATH", self.place.path("bin")).env("CALLS", self.place.path("calls"));
        command.env("MODELS", "0:2 1:5").env("FRAMES", self.place.path("photos"));
        command
    }

    pub(super) fn run(&self, options: &str, variables: &[(&str, &str)]) -> Output {
        self.command(options).envs(variables.iter().copied()).output().unwrap()
    }

    pub(super) fn ok(&self, options: &str) -> Value {
        let output = self.run(options, &[]);
        assert!(output.status.success(), "{options}: {}", text(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap_or(Value::Null)
    }

    /// The last line of a run that fails.
    pub(super) fn line(&self, options: &str, variables: &[(&str, &str)]) -> String {
        let output = self.run(options, variables);
        assert_eq!(output.status.code(), Some(1), "{options}");
        let said = text(&output.stderr);
        said.trim_end().lines().last().unwrap().strip_prefix("pocketnerf: ").unwrap().to_owned()
    }

    /// What the programs were asked so far: their first words.
    pub(super) fn calls(&self) -> Vec<String> {
        let calls = std::fs::read_to_string(self.place.path("calls")).unwrap_or_default();
        calls.lines().map(|line| line.split(' ').next().unwrap().to_owned()).collect()
    }
}
