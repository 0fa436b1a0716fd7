//! Whether verdicts agree with what the arm feels. An object that is pushed along has given way, and one that takes a
//! force where it is has held, whatever it was called.

use glam::DVec3;
use underbrush_recording::ObstacleKind;

use super::contacts::{GIVES_WAY, Judged, touches};
use super::map::Touch;

/// An object that the skin pushes this far has given way, m. Choice: more than a touch seems to move when it slides half
/// a hand's breadth over taxels whose normals are 15° apart (13 mm).
const GAVE_WAY_M: f64 = 0.02;
/// An object on which the force rises by this share of the usual limit within this distance, m, and time, s, has held: with
/// 3 N, it is stiffer than 190 N/m. Leaves bend at 5 to 50 N/m, and the skin alone gives way by 3 to 5 mm. Half of it is enough
/// for what is called fixed, which the arm presses half as hard.
const HELD: f64 = 0.5;
const HELD_IF_CALLED: f64 = 0.25;
const HELD_M: f64 = 0.008;
const HELD_S: f64 = 0.4;
/// A touch this close to one before, m, and in time, s, is of the same object.
const SAME_M: f64 = 0.04;
const SAME_S: f64 = 0.3;

/// What the arm felt of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Felt {
    GaveWay,
    Held,
}

/// An object in contact.
#[derive(Clone, Debug)]
struct Pressed {
    first: Touch,
    first_n: f64,
    last_world: DVec3,
    last_s: f64,
    felt: Option<Felt>,
}

/// How often verdicts were right.
#[derive(Clone, Debug, Default)]
pub(super) struct Trust {
    pressed: Vec<Pressed>,
    right: usize,
    wrong: usize,
    /// Whether verdicts are not believed any more, because they have been wrong more often than right.
    pub(super) is_lost: bool,
}

impl Pressed {
    /// Whether what is touched at this place is this object.
    fn is_at(&self, position_world: DVec3) -> bool {
        self.last_world.distance(position_world) < SAME_M
    }

    /// Takes in another touch with its largest force on a taxel, N. What resists by `held_n`, N, holds. Returns what the touch
    /// shows if nothing was known before.
    fn feel(&mut self, touch: &Touch, force_n: f64, held_n: f64) -> Option<Felt> {
        (self.last_world, self.last_s) = (touch.position_world, touch.time_s);
        if self.felt.is_some() {
            return None;
        }
        let pushed_m = (touch.position_world - self.first.position_world).dot(self.first.outward_normal_world);
        let is_hard = force_n - self.first_n > held_n && touch.time_s - self.first.time_s < HELD_S;
        self.felt = match pushed_m {
            pushed_m if pushed_m > GAVE_WAY_M => Some(Felt::GaveWay),
            pushed_m if pushed_m < HELD_M && is_hard => Some(Felt::Held),
            _ => None,
        };
        self.felt
    }
}

impl Trust {
    /// Takes in the contacts of an instant with their verdicts. Returns the touches that were called fixed and have given
    /// way just now.
    pub(super) fn take_in(&mut self, contacts: &[Judged], usual_n: f64, time_s: f64) -> Vec<Touch> {
        self.pressed.retain(|own| time_s - own.last_s < SAME_S);
        let mut given_way = Vec::new();
        for kind in [ObstacleKind::Fixed, ObstacleKind::Doubtful, ObstacleKind::Yielding] {
            let held_n = usual_n * if kind == ObstacleKind::Fixed { HELD_IF_CALLED } else { HELD };
            for (force_n, touch) in touches(contacts, kind, time_s) {
                let Some(own) = self.pressed.iter_mut().find(|own| own.is_at(touch.position_world)) else {
                    let (last_world, last_s) = (touch.position_world, time_s);
                    self.pressed.push(Pressed { first: touch, first_n: force_n, last_world, last_s, felt: None });
                    continue;
                };
                match (own.feel(&touch, force_n, held_n), kind) {
                    (None, _) | (_, ObstacleKind::Doubtful) => {}
                    (Some(Felt::Held), ObstacleKind::Fixed) => self.right += 1,
                    (Some(Felt::GaveWay), ObstacleKind::Fixed) => {
                        self.wrong += 1;
                        given_way.push(touch);
                    }
                    (Some(Felt::GaveWay), ObstacleKind::Yielding) => self.right += 1,
                    (Some(Felt::Held), ObstacleKind::Yielding) => self.wrong += 1,
                }
            }
        }
        self.is_lost |= self.wrong > self.right;
        given_way
    }

    /// Whether what is touched has held.
    pub(super) fn has_held(&self, touch: &Touch) -> bool {
        self.has_felt(Felt::Held, touch.position_world)
    }

    /// Raises the limits of contacts with what has given way.
    pub(super) fn allow_what_gave_way(&self, contacts: &mut [Judged], usual_n: f64) {
        for own in contacts {
            if self.has_felt(Felt::GaveWay, own.contact.position_world) {
                own.limit_n = own.limit_n.max(GIVES_WAY * usual_n);
            }
        }
    }

    fn has_felt(&self, felt: Felt, position_world: DVec3) -> bool {
        self.pressed.iter().any(|own| own.is_at(position_world) && own.felt == Some(felt))
    }
}
