//! Leaf: a bendable cantilever stuck in foam (paper, section IV-A).

use glam::DVec3;
use underbrush_recording::Category;

use super::{
    Axis, Blade, Body, COLLISION_THICKNESS_M, CollisionGroup, Declared, Drawing, EARTH_GRAVITY_M_PER_S2, FRICTION,
    Footing, Grip, Hinge, Joint, Kind, NEVER_PULLED_N, NEVER_YIELDS_NM, Object, Parameters, SHEET_TORSION_OVER_BENDING,
    Structure, grip, on_root, quantities, root_stiffness_nm_per_rad, yields,
};
use crate::{Draw, DrawError, Footprint, Surface};

quantities! {
    /// What is drawn for a leaf. The foot frame of its blade: x normal to the blade, y along its width, z up.
    struct DrawnLeaf {
        // Choice: half the height of a foam block. Limits: from a stem that hardly holds to the height of two blocks.
        /// How deep the stem is stuck into the foam, m.
        root_depth_m: Draw::Uniform(0.03, 0.05), 0.005, 0.2;
        // Choice: the paper's leaves were stuck stably.
        /// Pull at which the root begins to slide out of the foam, N. It falls as the root comes out. 1000: never.
        pull_out_force_n: Draw::Fixed(NEVER_PULLED_N), 0.01, NEVER_PULLED_N;
        // Choice: the foliage in the paper's Fig. 2 looks 25–40 cm high. The arm passes over lower leaves than the limit;
        // higher ones are bushes.
        /// Height over the foam, m.
        height_m: Draw::Uniform(0.25, 0.40), 0.05, 1.0;
        // Blades of artificial plants are 20–50 mm wide. Limits: from a blade of grass to a banana leaf.
        /// Width of the blade, m.
        width_m: Draw::Uniform(0.02, 0.05), 0.003, 0.3;
        // E I = E w t³ / 12 of plastic sheet ranges from 1e-4 to 4e-2 N m². Choice: far below 5e-3 a leaf of this height
        // could not carry its own weight, and a leaf that cannot is drawn again. Limits: from thin foil (a blade 3 mm
        // wide, 0.1 mm thick) to a plastic rod of 1 cm.
        /// Flexural rigidity E I of the blade, N m².
        flexural_rigidity_n_m2: Draw::Uniform(0.005, 0.05), 1.0e-5, 10.0;
        // That of a sheet; a midrib of wire bends like a stiffer sheet, and twists no less easily. Limits: from such a
        // blade to a solid round rod of Poisson's ratio 0, whose ratio is 1, and more than any sheet.
        /// Torsional over flexural rigidity, G J / (E I).
        torsion_over_bending: Draw::Fixed(SHEET_TORSION_OVER_BENDING), 0.01, 2.0;
        // Choice: the leaves return, as those of the paper do.
        /// Bending moment beyond which the blade folds and keeps a set, N m. 1000: never. A plastic leaf of 0.5–1 mm folds at
        /// 0.15–1.
        yield_moment_nm: Draw::Fixed(NEVER_YIELDS_NM), 0.001, NEVER_YIELDS_NM;
        // Plastic sheet of 0.5–1.2 mm. Limits: from foil of 10 µm to 2 cm of wood.
        /// Mass per area, kg/m².
        mass_per_area_kg_per_m2: Draw::Uniform(0.5, 1.0), 0.01, 20.0;
        // Low-density polyethylene and soft PVC, from which leaves and stems are moulded, have tan δ of 0.1–0.2 at room
        // temperature; the air's drag on a swinging blade adds some hundredths. Rubber at its glass transition reaches 2.
        /// Loss factor of the material.
        loss_factor: Draw::Uniform(0.1, 0.2), 0.0, 2.0;
        // Choice: with four, a leaf that is pushed at a third of its height or higher is within 4 % of the continuous
        // beam, far less than the uncertainty of a plant's stiffness. The engine's cost grows with the cube of the number.
        /// Number of elastic segments, each with one hinge; the nearest whole number of what is drawn.
        segments: Draw::Fixed(4.0), 2.0, 40.0;
    }
}

impl Kind for Leaf {
    const GROUP: (&'static str, &'static str) = (
        "LeafSpecification",
        "A group of leaves in a scene file. They stand on foam blocks only. The blade's foot frame: x normal to the blade, \
         y along its width, z up.",
    );
    const QUANTITIES: &'static [Declared] = DrawnLeaf::DECLARED;
    const CATEGORY: Category = Category::LEAF;
    const NEEDS_FOAM: bool = true;

    fn draw(drawing: &mut Drawing<'_>, footing: &Footing) -> Result<Self, DrawError> {
        let draw = |drawing: &mut Drawing<'_>| {
            let drawn = DrawnLeaf::draw_all(drawing)?;
            let root = footing.foam_modulus_pa.map(|modulus| root_stiffness_nm_per_rad(modulus, drawn.root_depth_m));
            Ok(Leaf {
                height_m: drawn.height_m,
                width_m: drawn.width_m,
                flexural_rigidity_n_m2: drawn.flexural_rigidity_n_m2,
                torsion_over_bending: drawn.torsion_over_bending,
                mass_per_area_kg_per_m2: drawn.mass_per_area_kg_per_m2,
                loss_factor: drawn.loss_factor,
                yield_moment_nm: yields(drawn.yield_moment_nm),
                root_stiffness_nm_per_rad: root,
                grip: grip(footing.foam_modulus_pa, drawn.root_depth_m, drawn.pull_out_force_n),
                segments: drawn.segments.round() as u32,
            })
        };
        // If nearly all leaves of these ranges would lie down, the error asks for a higher rigidity.
        let enough = |leaf: &Leaf| leaf.flexural_rigidity_n_m2 * leaf.load_share() / LARGEST_LOAD_SHARE;
        let refusal = |leaf: &Leaf| ("flexural_rigidity_n_m2", Some(enough(leaf)), None);
        drawing.until_possible(draw, Leaf::stands_by_itself, refusal)
    }
}

/// One leaf: a [`Blade`] on a root that rotates in the foam about both horizontal axes and twists a little.
///
/// The root's rotation about the blade's weak axis and its twist are less than a segment from the lowest hinge and are
/// combined with it ([`Leaf::hinges`]).
///
/// ```
/// use underbrush_sim::object::Object;
/// use underbrush_sim::object::leaf::Leaf;
///
/// let leaf = Leaf {
///     height_m: 0.3,
///     width_m: 0.03,
///     flexural_rigidity_n_m2: 0.02,
///     torsion_over_bending: 1.5,
///     mass_per_area_kg_per_m2: 0.7,
///     loss_factor: 0.15,
///     yield_moment_nm: None,
///     root_stiffness_nm_per_rad: None,
///     grip: None,
///     segments: 4,
/// };
/// assert!(leaf.stands_by_itself());
/// // The foot, the piece on the root that leans, and a piece that bends and twists at each of four hinges.
/// assert_eq!(leaf.structure(9.81).bodies.len(), 6);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leaf {
    /// Height, m.
    pub height_m: f64,
    /// Width, m.
    pub width_m: f64,
    /// Flexural rigidity E I about the blade's weak axis, N m².
    pub flexural_rigidity_n_m2: f64,
    /// Torsional over flexural rigidity, G J / (E I).
    pub torsion_over_bending: f64,
    /// Mass per area, kg/m².
    pub mass_per_area_kg_per_m2: f64,
    /// Loss factor η; the first mode's damping ratio is η/2.
    pub loss_factor: f64,
    /// The bending moment beyond which the blade folds and keeps a set, N m; `None` for a blade that always returns.
    pub yield_moment_nm: Option<f64>,
    /// Rotational stiffness of the root in the foam, N m/rad; `None` for a clamped root.
    pub root_stiffness_nm_per_rad: Option<f64>,
    /// What holds the root if it can be pulled out.
    pub grip: Option<Grip>,
    /// Number of elastic segments, each with one hinge.
    pub segments: u32,
}

/// Artificial leaves stand on a stem of round wire, about a quarter of their height and several times as stiff as the
/// blade. Sideways, where the blade itself does not bend, the stem does. Choices.
const STEM_SHARE_OF_HEIGHT: f64 = 0.25;
const STEM_RIGIDITY_OVER_BLADE: f64 = 4.0;

/// A leaf stands by itself if its weight is at most this share of its buckling load. Choice: its stiffness is then at
/// least 3/5 of a weightless leaf's.
const LARGEST_LOAD_SHARE: f64 = 0.4;

impl Leaf {
    /// What is recorded of it.
    pub(in crate::object) fn values(&self) -> Parameters {
        let parameters = [
            ("height_m", Some(self.height_m)),
            ("width_m", Some(self.width_m)),
            ("flexural_rigidity_n_m2", Some(self.flexural_rigidity_n_m2)),
            ("torsion_over_bending", Some(self.torsion_over_bending)),
            ("mass_per_area_kg_per_m2", Some(self.mass_per_area_kg_per_m2)),
            ("loss_factor", Some(self.loss_factor)),
            ("segments", Some(f64::from(self.segments))),
            ("yield_moment_nm", self.yield_moment_nm),
            ("root_stiffness_nm_per_rad", self.root_stiffness_nm_per_rad),
            ("pull_out_force_n", self.grip.map(|grip| grip.force_n)),
        ];
        parameters.into_iter().filter_map(|(name, value)| Some((name, value?))).collect()
    }

    /// The blade.
    pub fn blade(&self) -> Blade {
        Blade {
            length_m: self.height_m,
            width_m: self.width_m,
            flexural_rigidity_n_m2: self.flexural_rigidity_n_m2,
            torsional_rigidity_n_m2: self.torsion_over_bending * self.flexural_rigidity_n_m2,
            mass_per_area_kg_per_m2: self.mass_per_area_kg_per_m2,
            loss_factor: self.loss_factor,
            yield_moment_nm: self.yield_moment_nm,
            segments: self.segments,
        }
    }

    /// The leaf's weight as a share of its buckling load: that of the blade, plus the weight's destabilizing moment
    /// g ρA H² / 2 over the stiffness of the root.
    pub fn load_share(&self) -> f64 {
        let blade = self.blade();
        let moment_nm = EARTH_GRAVITY_M_PER_S2 * blade.mass_per_length_kg_per_m() * self.height_m.powi(2) / 2.0;
        blade.load_share(EARTH_GRAVITY_M_PER_S2) + self.root_stiffness_nm_per_rad.map_or(0.0, |k| moment_nm / k)
    }

    /// Whether the leaf carries its own weight and returns upright.
    pub fn stands_by_itself(&self) -> bool {
        self.load_share() <= LARGEST_LOAD_SHARE
    }

    /// Stiffness of the root against leaning sideways, along the blade's width, N m/rad: stem and foam in series.
    pub fn sideways_stiffness_nm_per_rad(&self) -> f64 {
        let stem = STEM_RIGIDITY_OVER_BLADE * self.flexural_rigidity_n_m2 / (STEM_SHARE_OF_HEIGHT * self.height_m);
        self.root_stiffness_nm_per_rad.map_or(stem, |root| stem * root / (stem + root))
    }

    /// The hinges of the blade, the lowest one together with the root in the foam, which is softer.
    pub fn hinges(&self) -> Vec<Hinge> {
        on_root(self.blade().hinges(), self.root_stiffness_nm_per_rad)
    }
}

impl Object for Leaf {
    fn size(&self) -> (Footprint, f64) {
        (Footprint::Disc(self.width_m / 2.0), self.height_m)
    }

    fn half_sizes_m(&self) -> [f64; 2] {
        [COLLISION_THICKNESS_M / 2.0, self.width_m / 2.0]
    }

    fn structure(&self, _: f64) -> Structure {
        let (blade, hinges) = (self.blade(), self.hinges());
        let sideways = blade.damped(self.sideways_stiffness_nm_per_rad());
        let lowest = Body {
            joint: Some(Joint::parallel(0, DVec3::ZERO, vec![(Axis::about(DVec3::X), sideways)])),
            collision_group: CollisionGroup::Rooted,
            ..blade.piece(0.0, hinges.first().map_or(self.height_m, |hinge| hinge.place_m))
        };
        let mut bodies = vec![Body::foot(), lowest];
        blade.grow(&hinges, self.height_m, 0.0, &mut bodies);
        // The piece beyond the lowest hinge may stand inside foam, too.
        if let Some(second) = bodies.get_mut(2) {
            second.collision_group = CollisionGroup::Rooted;
        }
        Structure { bodies, axisymmetric: false, surface: Surface::hard(FRICTION) }.held_by(self.grip)
    }
}
