//! Single rays that the solver was once wrong about.

use crate::fixture::{Fixture, double, single};
use crate::generated::{BodyRay, NONE};
use crate::revolution::lab::{Lab, body_ray};
use crate::revolution::profiles::{self, Profile};

/// A ray in unit space by its bits, and a root that it has.
struct Case {
    body: &'static str,
    origin: [u32; 3],
    direction: [u32; 3],
    k: f64,
    /// Whether no root is nearer.
    nearest: bool,
}

/// Bodies that chance made.
fn random() -> [Profile; 2] {
    let quintic = [
        [0.0, -0.53],
        [0.018, 0.048],
        [0.013, 0.308],
        [0.441, 0.82],
        [0.943, -0.943],
        [0.88, 0.625],
        [0.627, -0.813],
        [0.853, -0.252],
        [0.853, -0.252],
        [0.351, -0.587],
        [0.0, 0.454],
    ];
    let sextic = [
        [0.5, 0.376],
        [0.038, -0.202],
        [0.034, 0.703],
        [0.188, 0.022],
        [0.844, 0.06],
        [0.844, 0.06],
        [0.024, -0.465],
        [0.414, 0.837],
        [0.414, 0.837],
        [0.722, -0.876],
        [0.915, 0.566],
        [0.459, 0.088],
        [0.44, 0.932],
        [0.708, -0.448],
        [0.973, 0.309],
        [0.151, 0.913],
        [0.552, -0.572],
        [0.153, 0.94],
        [0.0, -0.164],
    ];
    [Profile::new("quintic", 5, &quintic), Profile::new("sextic", 6, &sextic)]
}

fn body(name: &str) -> Profile {
    let mut all = Vec::from(profiles::reference());
    all.extend(profiles::special());
    all.extend(random());
    all.into_iter().find(|profile| profile.name == name).expect("a body")
}

impl Case {
    fn ray(&self, lab: &Lab) -> BodyRay {
        let render = |bits: [u32; 3]| {
            let unit = double(bits.map(f32::from_bits));
            single(lab.subject.render_from_unit.transform_vector3(unit))
        };
        body_ray(render(self.origin), render(self.direction))
    }

    /// What is wrong with the ray's hits: its root must be found to 1e-4 of the body's size.
    fn complaint(&self, fixture: &Fixture) -> Option<String> {
        let lab = Lab::exact(fixture, &body(self.body), 1);
        let ray = self.ray(&lab);
        let roots = lab.subject.oracle.solve(&lab.subject.line(&ray));
        assert!(roots.iter().any(|root| (root.k - self.k).abs() < 1e-8), "{}: {} is no root", self.body, self.k);
        let same = |t: f32| (f64::from(t) - self.k).abs() * double(ray.direction).length() <= 1e-4;
        let alone = BodyRay { t_min: (self.k - 1e-3) as f32, t_max: (self.k + 1e-3) as f32, ..ray };
        let found = lab.find(&[alone]).swap_remove(0);
        let met = lab.meet(&[ray])[0];
        let right =
            found.iter().any(|found| same(found.t)) && (!self.nearest || (met.primitive != NONE && same(met.t)));
        (!right).then(|| format!("{}: {} is not found, but {found:?} and {} first", self.body, self.k, met.t))
    }
}

fn check(cases: &[Case]) {
    let fixture = Fixture::new();
    let complaints: Vec<_> = cases.iter().filter_map(|case| case.complaint(&fixture)).collect();
    assert!(complaints.is_empty(), "{complaints:#?}");
}

/// The closest approach must keep its digits without fused multiplication and addition too,
/// which not every device has.
#[test]
fn rays_from_afar() {
    check(&[
        Case {
            body: "cone",
            origin: [0x4216_01d2, 0xc2b1_51ee, 0xc32e_e63f],
            direction: [0xbec0_8368, 0x3f62_8d2b, 0x3fe0_792c],
            k: 99.715_429_861,
            nearest: true,
        },
        Case {
            body: "cup",
            origin: [0xc301_0ab4, 0xc30c_037a, 0xc1ee_0242],
            direction: [0x3fa5_e5ec, 0x3fb2_dd7a, 0x3e9b_30ed],
            k: 99.866_049_372,
            nearest: true,
        },
        // From 5 away, which are 8000 radii.
        Case {
            body: "needle",
            origin: [0x45cf_ae56, 0x45d9_bfbe, 0x4082_c95f],
            direction: [0xc4a6_2494, 0xc4ae_358a, 0xbf2e_2b4b],
            k: 4.999_872_918,
            nearest: true,
        },
    ]);
}

/// A ray that runs along a piece takes many intervals, and must not lose another root there.
#[test]
fn rays_that_graze_a_piece_and_cross_it() {
    check(&[
        Case {
            body: "inflections",
            origin: [0x3ebc_b033, 0xbde5_e847, 0x3f66_b67d],
            direction: [0x3e72_fb5c, 0x3f31_071d, 0xbfee_4873],
            k: 0.180_677_417,
            nearest: true,
        },
        Case {
            body: "cup",
            origin: [0x3d2d_392e, 0xbe28_d067, 0xbf03_e296],
            direction: [0xbfec_792a, 0x3e1c_2fb9, 0xbec0_3339],
            k: 0.071_797_195,
            nearest: true,
        },
    ]);
}

/// The surface lies 1 to 2e-6 over the ray for 1e-4 of its way, which is not flat to fp32.
#[test]
fn rays_that_cut_a_sliver() {
    check(&[
        Case {
            body: "quintic",
            origin: [0x3f60_8bd8, 0x3f8d_c168, 0xbe97_bb1c],
            direction: [0xbf9e_baaf, 0xbfc7_db74, 0xbe1f_9f2f],
            k: 0.708_482_595,
            nearest: true,
        },
        Case {
            body: "sextic",
            origin: [0xc0d6_7f63, 0xbff5_cbf2, 0x3ff7_7828],
            direction: [0x3feb_95ab, 0x3f06_c59c, 0xbf14_41b6],
            k: 3.642_280_406,
            nearest: false,
        },
    ]);
}

/// The square of what the direction has across the axis vanishes.
#[test]
fn rays_that_are_not_quite_parallel_to_the_axis() {
    check(&[Case {
        body: "disc",
        origin: [0xbef5_c7d2, 0xbee7_f03b, 0x4498_3a2c],
        direction: [0x9e12_547a, 0x1ed3_18a5, 0xc400_0000],
        k: 2.377_803_012,
        nearest: true,
    }]);
}
