//! What a person says of builds, printers and orders: how a print ended, that it is printed again, that its cake is broken out, that a
//! build may be published, that a printer is down, that an order is closed. This is the one place where such a word is judged against the ledger; `farm/operate/operate`
//! looks into the queue folders first. None of these words needs a daemon to be said; one that is noted is carried out by the daemon.
//!
//! Copies that a word makes bad are printed again, so nobody may print them from the old file any more. As long as that file may lie
//! in a queue folder, the word is refused. Where the person insists, it is noted in the build's row, the file is taken back as
//! `ledger/builds/take_back` says, and only then the word is carried out. A word that makes no copy bad changes nothing about the file.

use std::collections::{BTreeMap, BTreeSet};

use build_file::format_count;
use serde::{Deserialize, Serialize};

use super::{
    outcome::{outcome_sentence, tell_outcome},
    pick::end_break_out,
    put_back::printed_copies,
    requeue::issue_again,
    said::{OperatorWord, SeenFile, SeenFiles, WordAnswer},
    withdrawal::{record_untouched, record_withdrawn, withdraw},
};
use crate::{
    BreakOutAnswer, BuildId, BuildRow, BuildState, EventKind, InQueueError, Ledger, LedgerError, PartId, PrintOutcome,
    PutBackReport, ReprintTarget, ToldOutcome,
    base::{error::Result, sql},
    store::change::LedgerChange,
};

/// How a person insists, as the command line, pages and programs do.
const HOW_TO_INSIST: &str = "`--anyway`, \"anyway\" on the page and in the API";

/// A word about one build, as its row keeps it until the file is taken back.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum BuildWord {
    Outcome(ToldOutcome),
    Reprint(Vec<(PartId, u32)>),
    Requeue,
    BreakOut,
    /// Why it is withdrawn.
    Withdraw(String),
    /// It was carried out: what was taken back is to be removed.
    CarriedOut,
}

/// What the file of a build is taken back for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TakenBackFor {
    /// The build is withdrawn.
    Withdrawal,
    /// Another word, which says that its copies are to be printed again.
    Word,
    /// It was carried out: what was taken back is to be removed.
    Nothing,
}

/// What a word about one build did.
#[derive(Debug, Default)]
struct WordEffect {
    sentences: Vec<String>,
    makes_bad: bool,
}

impl WordEffect {
    fn of_report(said: Option<String>, report: &PutBackReport) -> Self {
        let makes_bad = !report.put_back.is_empty() || !report.unwanted.is_empty();
        Self { sentences: said.into_iter().chain(report.sentences()).collect(), makes_bad }
    }
}

impl BuildWord {
    /// Whether the build was printed, by this word.
    fn says_printed(&self) -> bool {
        matches!(self, Self::BreakOut) || matches!(self, Self::Outcome(told) if told.outcome == PrintOutcome::Complete)
    }

    /// Carries the word out within a change.
    async fn apply(&self, change: &mut LedgerChange, build: BuildId, by: &str) -> Result<WordEffect> {
        Ok(match self {
            Self::Outcome(told) => {
                let said = outcome_sentence(change, build, told).await?;
                WordEffect::of_report(Some(said), &tell_outcome(change, build, told).await?)
            }
            Self::Reprint(copies) => {
                let mut report = PutBackReport::default();
                change.mark_bad(build, copies, by, true, &mut report).await?;
                WordEffect::of_report(None, &report)
            }
            Self::Requeue => {
                let new = issue_again(change, build, by).await?;
                let said = format!("Build {build} is issued once more as build {new}.");
                WordEffect { sentences: vec![said], makes_bad: true }
            }
            Self::BreakOut => match end_break_out(change, build, by).await? {
                BreakOutAnswer::Open(open) => {
                    let said = format!("Nobody said anything yet of {}.", format_count(open, "copy", "copies"));
                    WordEffect { sentences: vec![said], makes_bad: false }
                }
                BreakOutAnswer::Told(report) => {
                    WordEffect::of_report(Some(format!("Build {build} is broken out.")), &report)
                }
            },
            Self::Withdraw(reason) => {
                let report = withdraw(change, build, by, reason).await?;
                WordEffect { makes_bad: true, ..WordEffect::of_report(None, &report) }
            }
            Self::CarriedOut => WordEffect::default(),
        })
    }
}

impl Ledger {
    /// The published builds whose copies a word may make bad.
    pub async fn builds_meant(&self, word: &OperatorWord) -> Result<Vec<BuildRow>> {
        let ids: Vec<BuildId> = match word {
            OperatorWord::Outcome(build, _)
            | OperatorWord::Requeue(build)
            | OperatorWord::BreakOut(build)
            | OperatorWord::Withdraw(build, _) => vec![*build],
            OperatorWord::Release { .. }
            | OperatorWord::SeenTo(_)
            | OperatorWord::CloseOrder(_)
            | OperatorWord::Load { .. }
            | OperatorWord::PrinterDown { .. }
            | OperatorWord::PrinterUp { .. } => Vec::new(),
            OperatorWord::Reprint(target) => {
                let mut change = self.begin_change().await?;
                let copies = printed_copies(&mut change, target).await?;
                copies.into_iter().map(|(build, ..)| build).collect::<BTreeSet<_>>().into_iter().collect()
            }
        };
        let mut builds = Vec::new();
        for id in ids {
            builds.extend(self.find_build(id).await?.filter(|build| build.times.published_at.is_some()));
        }
        Ok(builds)
    }

    /// Carries a word out, as far as `seen` allows it. `anyway` = the person insists.
    pub async fn carry_out(&self, word: &OperatorWord, by: &str, seen: &SeenFiles, anyway: bool) -> Result<WordAnswer> {
        let (build, word) = match word {
            OperatorWord::Reprint(target) => return self.reprint(target, by, seen, anyway).await,
            OperatorWord::Release { build, seen } => {
                return Ok(WordAnswer::from(match self.release_build(*build, seen.as_deref(), by).await? {
                    true => format!("Build {build} is released and goes to the queue."),
                    false => format!("Build {build} was released before."),
                }));
            }
            OperatorWord::CloseOrder(name) => {
                return Ok(WordAnswer { sentences: self.close_order(name, by).await?, noted: Vec::new() });
            }
            OperatorWord::Load { machine, material, lot } => {
                let sentences = self.load_material(machine, (material, lot), by).await?;
                return Ok(WordAnswer { sentences, noted: Vec::new() });
            }
            OperatorWord::SeenTo(build) => {
                return Ok(WordAnswer::from(match self.mark_seen(*build, by).await? {
                    true => format!(
                        "The second file of build {build} is dismissed: what lies in a queue now is its only one."
                    ),
                    false => format!("The failed print of build {build} is dismissed; its copies are as they were."),
                }));
            }
            OperatorWord::PrinterDown { machine, printer, reason } => {
                self.take_printer_down(printer, machine, by, reason).await?;
                let said = format!("The printer {printer} is down: it is given no builds.");
                return Ok(WordAnswer::from(said));
            }
            OperatorWord::PrinterUp { machine, printer } => {
                return Ok(WordAnswer::from(match self.bring_printer_up(printer, machine, by).await? {
                    true => format!("The printer {printer} takes builds again."),
                    false => format!("The printer {printer} was not down."),
                }));
            }
            OperatorWord::Outcome(build, told) => (*build, BuildWord::Outcome(told.clone())),
            OperatorWord::Requeue(build) => (*build, BuildWord::Requeue),
            OperatorWord::BreakOut(build) => (*build, BuildWord::BreakOut),
            OperatorWord::Withdraw(build, reason) => (*build, BuildWord::Withdraw(reason.clone())),
        };
        // Who withdraws a build wants its file out of the queue: there is nothing to insist on.
        let is_withdrawal = matches!(word, BuildWord::Withdraw(_));
        let (insists, anyway) = (anyway, anyway || is_withdrawal);
        let mut change = self.begin_change().await?;
        ensure_no_word_noted(&mut change, build).await?;
        let effect = word.apply(&mut change, build, by).await?;
        let is_out = effect.makes_bad && is_out_of_queue(seen, build, insists)?;
        if is_withdrawal && is_out {
            return Err(LedgerError::NotInQueue(build));
        }
        if is_out || !effect.makes_bad {
            change.commit().await?;
            let mut sentences = effect.sentences;
            sentences.extend(seen.get(&build).filter(|_| word.says_printed()).and_then(still_lies));
            return Ok(WordAnswer { sentences, noted: Vec::new() });
        }
        // It could be carried out, so that it will be: nothing of it is recorded yet.
        drop(change);
        let mut change = self.begin_change().await?;
        let mut answer = WordAnswer::default();
        note_word(&mut change, build, &word, (by, anyway), &mut answer).await?;
        change.commit().await?;
        Ok(answer)
    }

    async fn reprint(&self, target: &ReprintTarget, by: &str, seen: &SeenFiles, anyway: bool) -> Result<WordAnswer> {
        let mut change = self.begin_change().await?;
        let mut chosen: BTreeMap<BuildId, Vec<(PartId, u32)>> = BTreeMap::new();
        for (build, part, copy) in printed_copies(&mut change, target).await? {
            chosen.entry(build).or_default().push((part, copy));
        }
        let (mut answer, mut report) = (WordAnswer::default(), PutBackReport::default());
        for (build, copies) in chosen {
            ensure_no_word_noted(&mut change, build).await?;
            if is_out_of_queue(seen, build, anyway)? {
                change.mark_bad(build, &copies, by, true, &mut report).await?;
            } else {
                note_word(&mut change, build, &BuildWord::Reprint(copies), (by, anyway), &mut answer).await?;
            }
        }
        change.commit().await?;
        answer.sentences.splice(0..0, report.sentences());
        Ok(answer)
    }

    /// Carries out the word that waits for the file of a build, which lies in no queue folder any more. `None` = none waits. What nobody
    /// printed, and of which no other outcome was told, is withdrawn. `is_taken_back` = the file lay there untouched, and nestd has it.
    pub async fn finish_noted_word(&self, build: BuildId, is_taken_back: bool) -> Result<Option<Vec<String>>> {
        let mut change = self.begin_change().await?;
        let (machine, state) = change.require_build(build).await?;
        let Some((by, word)) = noted_word(&mut change, build).await?.filter(|(_, word)| *word != BuildWord::CarriedOut)
        else {
            return Ok(None);
        };
        let tells_outcome =
            matches!(word, BuildWord::Outcome(_) | BuildWord::BreakOut) || state != BuildState::Published;
        if tells_outcome {
            // First of all, as it was: what follows was true of no file in the queue.
            let detail = format!("out of the queue, as {by} said");
            change.write_event(EventKind::Withdrawn, &machine, None, Some(build), &detail).await?;
        }
        let effect = word.apply(&mut change, build, &by).await?;
        set_word(&mut change, build, &by, &BuildWord::CarriedOut).await?;
        if change.require_build(build).await?.1 == BuildState::Published {
            let detail = format!("out of the queue, as {by} said: {}", effect.sentences.join(" "));
            record_withdrawn(&mut change, build, &by, &detail).await?;
        } else if tells_outcome && is_taken_back {
            record_untouched(&mut change, build).await?;
        }
        change.commit().await?;
        Ok(Some(effect.sentences))
    }

    /// What the file of a build is taken back for; `None` = it is not taken back.
    pub async fn taken_back_for(&self, build: BuildId) -> Result<Option<TakenBackFor>> {
        let word = word_of_row(sql::query_as(NOTED_ROW).bind(build).fetch_one(self.reader()?).await?)?;
        Ok(word.map(|(_, word)| match word {
            BuildWord::Withdraw(_) => TakenBackFor::Withdrawal,
            BuildWord::CarriedOut => TakenBackFor::Nothing,
            _ => TakenBackFor::Word,
        }))
    }

    /// The file of a build that was seen to be taken lies in a queue folder again: that of `printer`, with this marker.
    pub async fn record_back_in_queue(&self, build: BuildId, printer: &str, queue_id: &str) -> Result<()> {
        let mut change = self.begin_change().await?;
        let (machine, _) = change.require_build(build).await?;
        let set = sql::query(
            "UPDATE build SET taken_at = CASE WHEN state = 'published' THEN NULL ELSE taken_at END, printer = $1, queue_id = $2 \
             WHERE id = $3 AND taken_at IS NOT NULL AND move_to IS NULL AND withdraw_by IS NULL \
             AND (state = 'published' OR queue_id IS DISTINCT FROM $2)",
        );
        if set.bind(printer).bind(queue_id).bind(build).execute(change.db()).await? > 0 {
            let detail = format!("its file lies in the queue of {printer} again");
            change.write_event(EventKind::Found, &machine, None, Some(build), &detail).await?;
            change.commit().await?;
        }
        Ok(())
    }

    /// Number of copies of a withdrawn build that waited again when its file was taken back.
    pub async fn copies_of_withdrawal(&self, build: BuildId) -> Result<u32> {
        let query = sql::query_scalar(
            "SELECT count(*) FROM bad_placement l JOIN build b ON b.id = l.build_id \
             WHERE b.id = $1 AND l.is_owed AND l.told_at = b.withdrawn_at",
        );
        Ok(query.bind(build).fetch_one(self.reader()?).await?)
    }
}

/// Whether the file of a build is certainly in no queue. Under another name or altered, nobody can take it back, and of two files only
/// one. Where one of two is gone, it may be printed from that one: only who insists says that it is not.
fn is_out_of_queue(seen: &SeenFiles, build: BuildId, insists: bool) -> Result<bool> {
    match seen.get(&build).cloned() {
        Some(SeenFile::OutOfQueue) => Ok(true),
        Some(SeenFile::Altered { printer }) => Err(InQueueError::Altered { build, printer }.into()),
        Some(SeenFile::Copied { own, is_second, others }) => {
            Err(InQueueError::Copied { build, own, is_second, others }.into())
        }
        Some(SeenFile::SecondUnseen { places }) => Err(InQueueError::SecondUnseen { build, places }.into()),
        Some(SeenFile::SecondGone { .. }) if insists => Ok(false),
        Some(SeenFile::Untouched { .. }) => Ok(false),
        Some(SeenFile::SecondGone { printer, places }) => {
            Err(InQueueError::SecondGone { build, printer, places }.into())
        }
        None => Ok(false),
    }
}

/// What is said of a file that lies in its queue although its build is printed: a printer may have made itself a copy of it.
fn still_lies(seen: &SeenFile) -> Option<String> {
    let SeenFile::Untouched { printer } = seen else { return None };
    Some(format!(
        "Its file lies untouched in the queue of {printer}: take it out there, or it may be printed a second time."
    ))
}

fn parse_word(text: &str) -> Result<BuildWord> {
    let wrong = |error: serde_json::Error| LedgerError::InvalidRecord(error.to_string());
    serde_json::from_str(text).map_err(wrong)
}

/// Who wants the file of a build back, the word that waits for it, why it is withdrawn, and whether that is over already.
type NotedRow = (Option<String>, Option<String>, String, bool);

const NOTED_ROW: &str = "SELECT withdraw_by, withdraw_word, coalesce(withdraw_reason, ''), \
    withdrawn_at IS NOT NULL OR state <> 'published' FROM build WHERE id = $1";

/// The word that waits for the file of a build, and who said it. An earlier nestd wrote no word of a withdrawal.
fn word_of_row((by, word, reason, is_over): NotedRow) -> Result<Option<(String, BuildWord)>> {
    let Some(by) = by else { return Ok(None) };
    Ok(Some(match word {
        Some(word) => (by, parse_word(&word)?),
        None if is_over => (by, BuildWord::CarriedOut),
        None => (by, BuildWord::Withdraw(reason)),
    }))
}

async fn noted_word(change: &mut LedgerChange, build: BuildId) -> Result<Option<(String, BuildWord)>> {
    word_of_row(sql::query_as(NOTED_ROW).bind(build).fetch_one(change.db()).await?)
}

/// One word at a time: the first is carried out before another one is heard.
async fn ensure_no_word_noted(change: &mut LedgerChange, build: BuildId) -> Result<()> {
    change.require_build(build).await?;
    match noted_word(change, build).await? {
        Some(_) => Err(InQueueError::BeingTakenBack(build).into()),
        None => Ok(()),
    }
}

async fn set_word(change: &mut LedgerChange, build: BuildId, by: &str, word: &BuildWord) -> Result<()> {
    let text = serde_json::to_string(word).map_err(|error| LedgerError::InvalidRecord(error.to_string()))?;
    let set = sql::query("UPDATE build SET withdraw_by = $1, withdraw_word = $2 WHERE id = $3");
    set.bind(by).bind(text).bind(build).execute(change.db()).await?;
    Ok(())
}

/// Notes a word about a build whose file may lie in a queue, or refuses it.
async fn note_word(
    change: &mut LedgerChange,
    build: BuildId,
    word: &BuildWord,
    (by, anyway): (&str, bool),
    answer: &mut WordAnswer,
) -> Result<()> {
    let (machine, state) = change.require_build(build).await?;
    let query = sql::query_as("SELECT printer, move_to FROM build WHERE id = $1").bind(build);
    let (printer, move_to): (Option<String>, Option<String>) = query.fetch_one(change.db()).await?;
    if move_to.is_some() {
        return Err(InQueueError::OnItsWay(build).into());
    }
    if let (BuildWord::Reprint(copies), BuildState::Published) = (word, state) {
        let counted: u32 = sql::query_scalar("SELECT count(*) FROM placement WHERE build_id = $1")
            .bind(build)
            .fetch_one(change.db())
            .await?;
        if counted > copies.len() as u32 {
            return Err(InQueueError::NotTold { build }.into());
        }
    }
    let printer = printer.unwrap_or(machine);
    if !anyway {
        return Err(InQueueError::LiesThere { build, printer, insist: HOW_TO_INSIST }.into());
    }
    set_word(change, build, by, word).await?;
    answer.noted.push(build);
    answer.sentences.push(match word {
        BuildWord::Withdraw(_) => {
            format!("Build {build} is taken back out of the queue of {printer}, unless the printer is first. Its page says what became of it.")
        }
        _ => format!("Noted: the file of build {build} is taken out of the queue of {printer} first; then it is done."),
    });
    Ok(())
}
