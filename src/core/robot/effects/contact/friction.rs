//! Coefficients of friction that vary along a rod.

use std::sync::Arc;

use super::Contact;
use super::plan::{Curve, FrictionAlong, Pair};
use super::shapes::touch::Law;
use super::state::SidePlace;
use crate::description::rod::Profile;
use crate::description::schema::{Data, Friction, Kind, Limits, Part as _, PerAxis, Reader, Value};
use crate::error::Checker;
use crate::robot::effects::actuator::{AlongRod, AlongRodTable};

/// Coefficients of friction as users describe them.
#[derive(Clone, Debug, PartialEq)]
pub enum Coefficients {
    /// The same everywhere.
    Even(Friction<3>),
    /// That of sliding in any direction, along the rod of the first surface.
    Along(AlongRodTable),
}

impl Coefficients {
    /// No friction.
    pub const NONE: Self = Self::Even(Friction { sliding: PerAxis([0.0; 3]), at_rest: None });
}

impl Data for Coefficients {
    const KIND: Kind =
        Kind::OneOf("ContactFriction", &[Friction::<3>::KIND, Kind::Part(AlongRodTable::SCHEMA)]);

    fn read(value: &Value, reader: &mut Reader) -> Option<Self> {
        match value {
            Value::Number(_) | Value::Integer(_) | Value::List(_) => {
                Friction::read(value, reader).map(Self::Even)
            }
            Value::Table(_) => AlongRodTable::read(value, reader).map(Self::Along),
            Value::Part(_) => match value.part::<AlongRod>() {
                Some(AlongRod::Table(table)) => Some(Self::Along(table.clone())),
                _ => reader.wrong_type(value, &Self::KIND),
            },
            _ => reader.wrong_type(value, &Self::KIND),
        }
    }

    fn check(&self, limits: &Limits, reader: &mut Reader) {
        match self {
            Self::Even(friction) => friction.check(limits, reader),
            Self::Along(table) => {
                table.check(&Limits::NONE, reader);
                reader.at_key("values", |reader| {
                    for (i, value) in table.values.iter().enumerate().filter(|(_, value)| value.is_finite()) {
                        reader.at_item(i, |reader| value.check(limits, reader));
                    }
                });
            }
        }
    }

    fn write(&self) -> Value {
        match self {
            Self::Even(friction) => friction.write(),
            Self::Along(table) => Value::Part(Arc::new(AlongRod::Table(table.clone()))),
        }
    }
}

impl FrictionAlong {
    fn at(&self, arc: f64) -> f64 {
        let [friction] = self.profile.at((arc / self.length).clamp(0.0, 1.0));
        // Rounding of cubics between values of zero may be below it.
        friction.max(0.0)
    }
}

impl Contact {
    /// The largest coefficients of friction: forward, backward and sideways.
    pub fn largest_friction(&self) -> [f64; 3] {
        match &self.friction_along {
            Some(table) => [table.values.iter().copied().fold(0.0, f64::max); 3],
            None => self.friction,
        }
    }

    /// Its friction along the rod; `None` if it is the same everywhere.
    pub(super) fn varying_friction(&self) -> Option<FrictionAlong> {
        let table = self.friction_along.as_ref()?;
        let values: Vec<_> = table.values.iter().map(|value| [*value]).collect();
        let profile = Profile::table(&table.stations, &values).ok().filter(|found| !found.is_constant())?;
        Some(FrictionAlong { profile, length: *table.stations.last()? })
    }

    /// Reports a table of friction that does not end with the rod; `length` gives those of the links.
    pub(super) fn check_friction(&self, check: &mut Checker, length: &dyn Fn(usize) -> Option<f64>) {
        let Some(AlongRodTable { stations, values }) = &self.friction_along else { return };
        let values: Vec<_> = values.iter().map(|value| [*value]).collect();
        if let (Ok(profile), Some(length)) =
            (Profile::table(stations, &values), self.surfaces[0].link().and_then(length))
        {
            check.nested("friction", profile.validate(length));
        }
    }
}

impl Pair {
    /// The law at a place of the first side, with at most this stiffness.
    pub(super) fn law_at<P>(&self, on: SidePlace, stiffest: f64, curves: &[Curve<P>]) -> Law {
        let stiffness = self.law.stiffness.min(stiffest);
        match (&self.friction_along, on) {
            (Some(along), SidePlace::Along { curve, x }) => {
                let Curve { start, length, .. } = &curves[curve];
                Law { stiffness, friction: [along.at(start + x * length); 3], ..self.law }
            }
            _ => Law { stiffness, ..self.law },
        }
    }
}
