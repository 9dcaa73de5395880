//! What a person asks to change of a part, and what may be asked.

use build_file::{
    LengthUnit, check_clearance, check_copies, check_email, check_finish, check_name, check_note, check_priority,
};
use jiff::Timestamp;
use nester::OrientationRule;
use serde::{Deserialize, Serialize};

use crate::{PartState, RequiredTilts};

/// Requested changes of a part; `None` = unchanged.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PartEdit {
    /// Copies wanted in all, those in builds included.
    pub copies: Option<u32>,
    /// Order, "" = none.
    pub order_name: Option<String>,
    /// Who it is for, "" = not said. It can always be changed.
    pub customer: Option<String>,
    /// Where that customer gets e-mail, "" = not said. It can always be changed.
    pub email: Option<String>,
    /// What it is to be made of, "" = anything.
    pub material: Option<String>,
    /// Finishing steps after the print, "" = none. They can always be changed.
    pub finish: Option<String>,
    /// Priority from 0 to 100.
    pub priority: Option<u8>,
    /// When it is due, and the date as it was given; the inner `None` = no due date.
    #[serde(with = "given_or_none")]
    pub due: Option<Option<(Timestamp, String)>>,
    /// Orientation rule.
    pub orientation: Option<OrientationRule>,
    /// Directions that must point nearly straight up.
    pub tilts: Option<RequiredTilts>,
    /// Its own clearance, mm; the inner `None` = the machine's.
    #[serde(with = "given_or_none")]
    pub clearance_mm: Option<Option<f64>>,
    /// Unit of the file: the part is read again.
    pub unit: Option<LengthUnit>,
    /// Free text.
    pub note: Option<String>,
}

impl PartEdit {
    /// Whether it changes nothing.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The same with clean texts.
    ///
    /// # Errors
    /// A value is beyond what may be asked of a part; the sentence says which, and what may be asked.
    pub fn checked(self) -> std::result::Result<Self, String> {
        let name = |word: &str, name: Option<String>| name.map(|name| check_name(word, &name)).transpose();
        if let Some(mm) = self.clearance_mm.flatten() {
            check_clearance(mm)?;
        }
        Ok(Self {
            copies: self.copies.map(|copies| check_copies(copies.into())).transpose()?,
            priority: self.priority.map(|priority| check_priority(priority.into())).transpose()?,
            order_name: name("order", self.order_name)?,
            customer: name("customer", self.customer)?,
            email: self.email.as_deref().map(check_email).transpose()?,
            material: name("material", self.material)?,
            finish: self.finish.as_deref().map(check_finish).transpose()?,
            note: self.note.as_deref().map(check_note).transpose()?,
            ..self
        })
    }

    /// Whether it changes how or whether copies may stand in a layout.
    pub fn changes_layout(&self) -> bool {
        self.orientation.is_some() || self.tilts.is_some() || self.clearance_mm.is_some() || self.unit.is_some()
    }

    /// What of it can be changed of a part in this state: of one of which nothing waits, only who it is for and how it is finished.
    pub fn possible_in(&self, state: PartState) -> Self {
        match state {
            PartState::Waiting | PartState::Claimed => self.clone(),
            _ => Self {
                customer: self.customer.clone(),
                email: self.email.clone(),
                finish: self.finish.clone(),
                ..Self::default()
            },
        }
    }

    pub(crate) fn changes_terms(&self) -> bool {
        Self { copies: None, customer: None, email: None, finish: None, ..self.clone() } != Self::default()
    }
}

/// A value that is given, or taken away. JSON has `null` for what is unchanged, as commands of earlier versions do, and `"none"` for what is taken
/// away: on its own, serde writes `null` for both.
mod given_or_none {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Serialize, Deserialize)]
    #[serde(untagged)]
    enum Given<T> {
        Nothing(Nothing),
        Value(T),
    }

    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    enum Nothing {
        None,
    }

    pub(super) fn serialize<S: Serializer, T: Serialize>(
        given: &Option<Option<T>>,
        into: S,
    ) -> Result<S::Ok, S::Error> {
        let given = given.as_ref().map(|given| given.as_ref().map_or(Given::Nothing(Nothing::None), Given::Value));
        given.serialize(into)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
        from: D,
    ) -> Result<Option<Option<T>>, D::Error> {
        Ok(Option::deserialize(from)?.map(|given| match given {
            Given::Nothing(Nothing::None) => None,
            Given::Value(value) => Some(value),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_taken_away_arrives_so_where_the_command_is_carried_out() {
        let due = Some((Timestamp::UNIX_EPOCH, "1970-01-01".to_owned()));
        for (due, clearance_mm) in [(Some(None), Some(None)), (Some(due), Some(Some(2.5))), (None, None)] {
            let edit = PartEdit { due, clearance_mm, ..PartEdit::default() };
            let written = serde_json::to_string(&edit).unwrap();
            assert_eq!(serde_json::from_str::<PartEdit>(&written).unwrap(), edit, "{written}");
        }
        let earlier = r#"{"copies":3,"due":null,"clearance_mm":null}"#;
        let unchanged = PartEdit { copies: Some(3), ..PartEdit::default() };
        assert_eq!(serde_json::from_str::<PartEdit>(earlier).unwrap(), unchanged, "of a command of an earlier version");
    }
}
