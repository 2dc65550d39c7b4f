//! A control's tooltip is its flag's help: one sentence, written once.

use std::collections::HashMap;

use clap::CommandFactory;

use crate::app::cli::Cli;

/// By flag, without its dashes.
pub struct Tips(HashMap<String, String>);

impl Tips {
    /// Of `prism run`.
    pub fn new() -> Tips {
        let command = Cli::command();
        let arguments = command.find_subcommand("run").into_iter().flat_map(|run| run.get_arguments());
        let tip = |argument: &clap::Arg| {
            let flag = argument.get_long()?.to_owned();
            let help = argument.get_help()?.to_string();
            let sentence = help.split(" [default").next().unwrap_or_default().trim().to_owned();
            Some((flag.clone(), format!("{sentence}.\n--{flag}")))
        };
        Tips(arguments.filter_map(tip).collect())
    }

    /// What a flag does.
    pub fn of(&self, flag: &str) -> &str {
        self.0.get(flag).map_or("", String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_control_has_a_tip() {
        let tips = Tips::new();
        for flag in super::super::controls::FLAGS {
            assert!(tips.of(flag).ends_with(&format!("--{flag}")), "--{flag}: '{}'", tips.of(flag));
        }
    }
}
