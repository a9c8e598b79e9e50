//! `cargo xtask firmware`: the images that boards are flashed with, and how large they are.
//!
//! They are built in their package's folder, whose settings are those of `cargo run --release` there: the same
//! bytes. The pinned compiler builds them where its target is there or can be fetched; elsewhere the
//! distribution's compiler does, together with its own `core` library.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use object::{Object, ObjectSection, ObjectSymbol, SectionKind};

use crate::prerequisites;
use crate::repository::{root, target_folder};
use crate::steps::{Outcome, run as run_command};

const TARGET: &str = "thumbv7em-none-eabihf";

/// Debian's compiler for the web browser's needs: newer than its other one.
const PACKAGES: [&str; 3] = ["rustc-web", "cargo-web", "rust-web-src"];

/// One board's image.
pub struct Board {
    /// As the user writes it.
    name: &'static str,
    /// Its binary.
    bin: &'static str,
    /// What that is built with.
    features: &'static str,
    /// Where its package is, with the settings of its build.
    folder: &'static str,
    /// What the compiler calls its chip.
    target: &'static str,
    /// Largest image \[KiB\]; what is in one is in docs/emulated-board.md. With USB: what it is and 2 %.
    flash_kib_max: u64,
    /// Most static memory \[KiB\]; the stack has 32 KiB besides.
    ram_kib_max: u64,
}

/// The boards, the reference board first.
pub const BOARDS: [Board; 7] = [
    Board {
        name: "nucleo-f429zi",
        bin: "nucleo_f429zi",
        features: "board-nucleo-f429zi",
        folder: "firmware",
        target: TARGET,
        flash_kib_max: 98,
        ram_kib_max: 24,
    },
    Board {
        name: "nucleo-f429zi-usb",
        bin: "nucleo_f429zi",
        features: "board-nucleo-f429zi,usb",
        folder: "firmware",
        target: TARGET,
        flash_kib_max: 112,
        ram_kib_max: 26,
    },
    Board {
        name: "nucleo-f446re",
        bin: "nucleo_f446re",
        features: "board-nucleo-f446re",
        folder: "firmware",
        target: TARGET,
        flash_kib_max: 98,
        ram_kib_max: 24,
    },
    Board {
        name: "nucleo-f411re",
        bin: "nucleo_f411re",
        features: "board-nucleo-f411re",
        folder: "firmware",
        target: TARGET,
        flash_kib_max: 98,
        ram_kib_max: 24,
    },
    Board {
        name: "nucleo-g474re",
        bin: "nucleo_g474re",
        features: "board-nucleo-g474re",
        folder: "firmware",
        target: TARGET,
        flash_kib_max: 98,
        ram_kib_max: 24,
    },
    Board {
        name: "black-pill-f411",
        bin: "black_pill_f411",
        features: "board-black-pill-f411",
        folder: "firmware",
        target: TARGET,
        flash_kib_max: 98,
        ram_kib_max: 24,
    },
    Board {
        name: "pico2",
        bin: "pico2",
        features: "",
        folder: "pico2",
        target: "thumbv8m.main-none-eabihf",
        flash_kib_max: 128,
        ram_kib_max: 32,
    },
];

/// Which compiler builds the images.
#[derive(Clone, Copy)]
enum Compiler {
    /// That of `rust-toolchain.toml`.
    Pinned,
    /// Debian's, with `core` built along.
    Distribution,
}

/// The chore: `[--board NAME] [--compiler pinned|distribution]`.
pub fn run(args: &[&str]) -> Outcome {
    let mut chosen: Vec<&Board> = BOARDS.iter().collect();
    let mut compiler = None;
    let mut rest = args;
    while let [option, value, tail @ ..] = rest {
        match *option {
            "--board" => {
                chosen.retain(|board| board.name == *value);
                if chosen.is_empty() {
                    let names = BOARDS.map(|board| board.name).join(", ");
                    return Err(format!("no board `{value}`\n       boards: {names}"));
                }
            }
            "--compiler" if *value == "pinned" => compiler = Some(Compiler::Pinned),
            "--compiler" if *value == "distribution" => compiler = Some(Compiler::Distribution),
            _ => return Err(usage()),
        }
        rest = tail;
    }
    if !rest.is_empty() {
        return Err(usage());
    }
    let compiler_of = |target| compiler.map_or_else(|| find_compiler(target), Ok);
    if chosen.len() == BOARDS.len() {
        check_library(compiler_of(TARGET)?)?;
    }
    for board in chosen {
        let image = build(board, compiler_of(board.target)?)?;
        board.weigh(&image)?;
    }
    Ok(())
}

fn usage() -> String {
    "use: cargo xtask firmware [--board NAME] [--compiler pinned|distribution]".into()
}

/// The reference board's image, built if it has changed.
pub fn reference_image() -> Result<PathBuf, String> {
    build(&BOARDS[0], find_compiler(TARGET)?)
}

/// Checks the images' code. Debian's compiler has no clippy: then only the pinned one's host build is.
pub fn clippy() -> Outcome {
    let Compiler::Pinned = find_compiler(TARGET)? else {
        println!("    left out: the distribution's compiler has no clippy");
        return Ok(());
    };
    for board in BOARDS.iter().filter(|board| board.target == TARGET) {
        let mut command = Command::new("cargo");
        command
            // Of the release build: its macros and build scripts are there already.
            .args(["clippy", "--release", "--locked"])
            .args(["--no-default-features", "--features", board.features])
            .args(["--bin", board.bin, "--target", TARGET, "--", "-D", "warnings"])
            .current_dir(root().join("firmware"))
            .env_remove("CARGO_ENCODED_RUSTFLAGS");
        run_command(&mut command, "fix what clippy says")?;
    }
    Ok(())
}

/// The pinned compiler if it has the target, or can fetch it; else the distribution's.
fn find_compiler(target: &str) -> Result<Compiler, String> {
    if has_target(target) {
        return Ok(Compiler::Pinned);
    }
    println!("    {target} is missing: trying to fetch it");
    if quiet("rustup", &["target", "add", target]) && has_target(target) {
        return Ok(Compiler::Pinned);
    }
    println!("    it cannot be fetched: the distribution's compiler builds the images");
    distribution_compiler(target)?;
    Ok(Compiler::Distribution)
}

fn has_target(target: &str) -> bool {
    let print = ["--print", "target-libdir", "--target", target];
    let Some(folder) = output("rustc", &print) else { return false };
    std::fs::read_dir(folder.trim()).is_ok_and(|files| {
        files.flatten().any(|file| file.file_name().to_string_lossy().starts_with("libcore-"))
    })
}

/// The library for a chip without a board of ours: it needs nothing of the STM32's.
fn check_library(compiler: Compiler) -> Outcome {
    let (mut command, _) = firmware_cargo("check", ("firmware", TARGET), compiler)?;
    command.arg("--lib");
    run_command(&mut command, "the library must build without the feature `stm32`")
}

/// Cargo in a package's folder, without features, and the build folder.
fn firmware_cargo(
    what: &str,
    (folder, target_name): (&str, &str),
    compiler: Compiler,
) -> Result<(Command, PathBuf), String> {
    let mut target = target_folder();
    let mut command = match compiler {
        Compiler::Pinned => Command::new("cargo"),
        Compiler::Distribution => {
            target.push("distribution");
            distribution_cargo(target_name)?
        }
    };
    command
        .args([what, "--release", "--locked", "--no-default-features", "--target", target_name])
        .arg("--target-dir")
        .arg(&target)
        .current_dir(root().join(folder))
        // Set for this program by `cargo xtask`; not for the image.
        .env_remove("CARGO_ENCODED_RUSTFLAGS");
    if let Compiler::Distribution = compiler {
        command.arg("-Zbuild-std=core,alloc");
    }
    Ok((command, target))
}

fn build(board: &Board, compiler: Compiler) -> Result<PathBuf, String> {
    let Board { bin, features, folder, target, .. } = *board;
    let (mut command, built) = firmware_cargo("build", (folder, target), compiler)?;
    command.args(["--features", features, "--bin", bin]);
    run_command(&mut command, "fix the build; its folder builds with `cargo build --release` too")?;
    Ok(built.join(target).join("release").join(bin))
}

/// Debian's compiler, installed if it can be.
fn distribution_compiler(target: &str) -> Outcome {
    let there = |path: &str| Path::new(path).exists();
    if !PACKAGES.iter().all(|package| quiet("dpkg", &["-s", package])) {
        prerequisites::install(&PACKAGES).map_err(|_| no_compiler(target))?;
    }
    if !there("/usr/bin/cargo") || !there("/usr/bin/rustc") {
        return Err(format!(
            "{} are installed, but /usr/bin/cargo is not there",
            PACKAGES.join(", ")
        ));
    }
    Ok(())
}

/// What to do where neither compiler can be had.
fn no_compiler(target: &str) -> String {
    format!(
        "no compiler here builds for boards: the target {target} is missing and cannot be fetched, and Debian's \
         compiler cannot be installed in its place\n       \
         do one of these, then repeat the command:\n       \
         - with a network, run `rustup target add {target}` in this folder\n       \
         - under Debian, as root, run `apt-get install {}`",
        PACKAGES.join(" ")
    )
}

/// Debian's cargo, with everything that it needs.
fn distribution_cargo(target: &str) -> Result<Command, String> {
    distribution_compiler(target)?;
    let linker_of =
        format!("CARGO_TARGET_{}_LINKER", target.to_uppercase().replace(['-', '.'], "_"));
    let mut command = Command::new("/usr/bin/cargo");
    command
        // Not rustup's, which stand earlier in the path.
        .env("PATH", "/usr/bin:/bin")
        .env("RUSTC", "/usr/bin/rustc")
        .env_remove("RUSTUP_TOOLCHAIN")
        // What builds `core` along is not stable; this compiler is, in all else.
        .env("RUSTC_BOOTSTRAP", "1")
        .env(linker_of, linker()?);
    Ok(command)
}

/// A linker for the chip: the pinned compiler's, or Debian's.
fn linker() -> Result<PathBuf, String> {
    if let (Some(sysroot), Some(version)) =
        (output("rustc", &["--print", "sysroot"]), output("rustc", &["-vV"]))
        && let Some(host) = version.lines().find_map(|line| line.strip_prefix("host: "))
    {
        let lld = Path::new(sysroot.trim()).join("lib/rustlib").join(host).join("bin/rust-lld");
        if lld.exists() {
            return Ok(lld);
        }
    }
    let lld = Path::new("/usr/bin/ld.lld");
    if !lld.exists() {
        prerequisites::install(&["lld"])?;
    }
    Ok(lld.into())
}

fn quiet(program: &str, args: &[&str]) -> bool {
    let mut command = Command::new(program);
    command.args(args).current_dir(root()).stdin(Stdio::null());
    command
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

fn output(program: &str, args: &[&str]) -> Option<String> {
    let output = Command::new(program).args(args).current_dir(root()).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

impl Board {
    /// Prints how large an image is, and refuses one that is too large.
    fn weigh(&self, image: &Path) -> Outcome {
        let bytes =
            std::fs::read(image).map_err(|error| format!("{}: {error}", image.display()))?;
        let weight = Weight::of(&bytes).map_err(|error| format!("{}: {error}", image.display()))?;
        println!(
            "    {}: {:.1} KiB of flash (at most {}), {:.1} KiB of static RAM (at most {})",
            self.name,
            weight.flash as f64 / 1024.0,
            self.flash_kib_max,
            weight.ram as f64 / 1024.0,
            self.ram_kib_max,
        );
        println!("    {}", image.display());
        // The Pico 2's is laid out by its own package's linker script.
        if self.folder == BOARDS[0].folder {
            check_stack(&bytes).map_err(|error| format!("{}: {error}", image.display()))?;
        }
        if weight.flash > self.flash_kib_max * 1024 || weight.ram > self.ram_kib_max * 1024 {
            return Err(format!("the image for {} is too large", self.name));
        }
        Ok(())
    }
}

/// Holds that the stack lies below every static, so that its overflow overwrites none.
fn check_stack(elf: &[u8]) -> Result<(), String> {
    let file = object::File::parse(elf).map_err(|error| error.to_string())?;
    let symbol = |name: &str| file.symbols().find(|symbol| symbol.name() == Ok(name));
    let top = symbol("_stack_start").map(|symbol| symbol.address()).ok_or("it has no stack")?;
    let is_static = |kind| matches!(kind, SectionKind::Data | SectionKind::UninitializedData);
    let statics = file.sections().filter(|section| is_static(section.kind()) && section.size() > 0);
    match statics.map(|section| section.address()).min() {
        Some(lowest) if lowest < top => {
            Err(format!("statics at {lowest:#x} lie below the stack, which begins at {top:#x}"))
        }
        _ => Ok(()),
    }
}

/// What an image takes \[bytes\].
#[derive(Debug, PartialEq, Eq)]
struct Weight {
    flash: u64,
    ram: u64,
}

impl Weight {
    /// Data with initial values is in both: in flash, and copied to RAM at the start.
    fn of(elf: &[u8]) -> Result<Self, object::Error> {
        let file = object::File::parse(elf)?;
        let mut weight = Self { flash: 0, ram: 0 };
        for section in file.sections() {
            match section.kind() {
                SectionKind::Text | SectionKind::ReadOnlyData | SectionKind::ReadOnlyString => {
                    weight.flash += section.size();
                }
                SectionKind::Data => {
                    weight.flash += section.size();
                    weight.ram += section.size();
                }
                SectionKind::UninitializedData => weight.ram += section.size(),
                _ => {}
            }
        }
        Ok(weight)
    }
}
