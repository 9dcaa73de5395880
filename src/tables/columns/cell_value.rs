//! A value in a table, not formatted yet. Files contain it in full; terminals and pages print it as its field
//! defines.

use ledger::{BuildId, BuildState, OrderState, PartId, PartState, PrintOutcome, UtcTimestamp};
use serde::Serialize;

use super::time_view::{GivenDate, PromisedDate};

/// A value in a table, not formatted yet.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum CellValue {
    /// The value is not known.
    Missing,
    /// A text; "" = none.
    Text(String),
    /// The word of a state.
    State(String),
    /// A text in which commands and options are between backticks.
    Prose(String),
    /// A whole number.
    Whole(i64),
    /// A number in the unit of its field; a share is between 0 and 1.
    Real(f64),
    /// A point in time.
    Time(UtcTimestamp),
    /// A point in time that nobody told: it goes by the plan.
    Estimate(UtcTimestamp),
    /// A due date. Programs get its instant.
    #[serde(serialize_with = "due_instant")]
    Due(GivenDate),
    /// When something will be done, and by how much that is late. Programs get its instant.
    #[serde(serialize_with = "promised_instant")]
    Promise(PromisedDate),
    /// A build, shown by its number.
    Build(BuildId),
    /// A build, shown by its number, with the part to find in it.
    BuildWithPart(BuildId, #[serde(skip)] PartId),
    /// A part, shown by its number.
    Part(PartId),
    /// An order, shown by its name; "" = none.
    Order(String),
    /// A part, shown by its name.
    NamedPart(#[serde(skip)] PartId, String),
}

fn due_instant<S: serde::Serializer>(due: &GivenDate, serializer: S) -> Result<S::Ok, S::Error> {
    due.due_at.serialize(serializer)
}

fn promised_instant<S: serde::Serializer>(promise: &PromisedDate, serializer: S) -> Result<S::Ok, S::Error> {
    promise.done_at.serialize(serializer)
}

impl CellValue {
    /// A time of the plan, if it is known.
    pub fn estimate(at: Option<UtcTimestamp>) -> Self {
        at.map_or(Self::Missing, Self::Estimate)
    }
}

impl<T: Into<CellValue>> From<Option<T>> for CellValue {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Missing, Into::into)
    }
}

macro_rules! cell_from {
    ($($kind:ty => $make:expr),+ $(,)?) => {
        $(impl From<$kind> for CellValue {
            fn from(value: $kind) -> Self {
                let make: fn($kind) -> Self = $make;
                make(value)
            }
        })+
    };
}

cell_from! {
    String => CellValue::Text,
    &String => |text| CellValue::Text(text.clone()),
    &str => |text| CellValue::Text(text.to_owned()),
    u8 => |number| CellValue::Whole(number.into()),
    u32 => |number| CellValue::Whole(number.into()),
    i64 => CellValue::Whole,
    u64 => |number| CellValue::Whole(i64::try_from(number).unwrap_or(i64::MAX)),
    usize => |number| CellValue::Whole(i64::try_from(number).unwrap_or(i64::MAX)),
    f64 => CellValue::Real,
    UtcTimestamp => CellValue::Time,
    GivenDate => CellValue::Due,
    PromisedDate => CellValue::Promise,
    BuildId => CellValue::Build,
    PartId => CellValue::Part,
    BuildState => |state| CellValue::State(state.to_string()),
    PartState => |state| CellValue::State(state.to_string()),
    OrderState => |state| CellValue::State(state.to_string()),
    PrintOutcome => |outcome| CellValue::State(outcome.to_string()),
}
