//! `underbrush completions`: what a shell needs to complete commands, and manual pages.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args, Command, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;
use serde_json::json;
use underbrush_recording::InputError;
use underbrush_recording::disk::{DiskError, is_folder, is_there};

use crate::{Cli, Failure, output};

/// Options of `underbrush completions`.
#[derive(Args)]
#[command(group(ArgGroup::new("what").required(true)), after_help = "\
bash:  underbrush completions bash > ~/.local/share/bash-completion/completions/underbrush
zsh:   underbrush completions zsh > ~/.zfunc/_underbrush      (with ~/.zfunc in fpath)
fish:  underbrush completions fish > ~/.config/fish/completions/underbrush.fish
man:   underbrush completions --manual ~/.local/share/man/man1")]
pub struct CompletionsOptions {
    /// Shell whose script to print
    #[arg(value_enum, group = "what")]
    shell: Option<Shell>,
    /// Folder to write manual pages to, one for each command. Pages of the same names are replaced
    #[arg(long, value_name = "DIR", group = "what")]
    manual: Option<PathBuf>,
}

/// Prints the script, or writes the pages.
pub fn run(options: CompletionsOptions, json: bool) -> Result<(), Failure> {
    let mut program = Cli::command();
    if let Some(shell) = options.shell {
        let mut script = Vec::new();
        clap_complete::generate(shell, &mut program, "underbrush", &mut script);
        return output::line(String::from_utf8_lossy(&script).trim_end());
    }
    let Some(folder) = options.manual else { return Ok(()) };
    if is_there(&folder)? && !is_folder(&folder)? {
        return Err(InputError::new(folder, "--manual", "a file", "a folder", "choose another folder").into());
    }
    program = program.disable_help_subcommand(true);
    program.build();
    let written = std::fs::create_dir_all(&folder).and_then(|()| write_pages(&program, &folder));
    written.map_err(DiskError::io(&folder, "write"))?;
    let folder = folder.display().to_string();
    output::result(json, &json!({ "manual": folder }), || format!("Wrote the manual pages to {folder}"))
}

/// Writes the manual pages of a command and of its subcommands.
fn write_pages(command: &Command, folder: &Path) -> std::io::Result<()> {
    for own in command.get_subcommands() {
        write_pages(own, folder)?;
    }
    let page = Man::new(command.clone());
    let mut text = Vec::new();
    page.render(&mut text)?;
    // Without these two requests words of the examples get hyphens, and spaces between them are widened.
    let text = String::from_utf8_lossy(&text).replace(".SH EXTRA\n", ".SH EXTRA\n.nh\n.ad l\n");
    std::fs::write(folder.join(page.get_filename()), text)
}
