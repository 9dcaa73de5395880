//! The control files of a machine that became commands.

use std::collections::VecDeque;

use ledger::CommandId;

/// Number of keys of control files that a machine remembers.
const MAX_KEYS: usize = 100;

/// The control files of a machine that became commands.
#[derive(Debug, Default)]
pub struct ObeyedControls {
    /// Keys of the files: one that could not be removed is not obeyed twice.
    keys: VecDeque<String>,
    /// The last command and the name of its file.
    last: Option<(CommandId, &'static str)>,
    /// The answer to the last command, for `STATUS.txt`; "" = there is none yet.
    pub answer: String,
}

impl ObeyedControls {
    /// Whether the file with this key became a command.
    pub fn is_obeyed(&self, key: &str) -> bool {
        self.keys.iter().any(|known| known == key)
    }

    /// Records that a file became a command.
    pub fn record_command(&mut self, key: String, command: CommandId, file_name: &'static str) {
        self.keys.push_back(key);
        if self.keys.len() > MAX_KEYS {
            self.keys.pop_front();
        }
        self.last = Some((command, file_name));
        self.answer.clear();
    }

    /// The last command and the name of its file, while the answer is not known.
    pub fn unanswered(&self) -> Option<(CommandId, &'static str)> {
        self.last.filter(|_| self.answer.is_empty())
    }
}
