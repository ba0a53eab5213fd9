//! A steel wire of one metre, held out horizontally and let go: `cargo run --release --example released_wire`.

#![allow(clippy::print_stdout, reason = "an example shows its results")]

use lissom::lie::Vector;
use lissom::newmark;
use lissom::robot::{RobotModel, Rod};
use lissom::rod::Segment;
use lissom::simulate::{Method, simulate};

fn main() -> Result<(), lissom::error::InvalidInput> {
    let segment = Segment {
        modes: [0, 3, 0, 0, 0, 0], // three of bending in the vertical plane
        retardation_time: 1e-4,    // seconds
        ..Segment::straight(1.0, 1e-3, 210e9, 80e9, 7800.0)
    };
    let mut wire = RobotModel::of_rod(&Rod::new(vec![segment]))?;
    let tip = wire.place(1.0);

    let at_rest = [0.0; 3];
    let method = Method::Newmark(newmark::Options::new(1e-3));
    let motion = simulate(wire.clone(), (0.0, 1.0), &at_rest, &at_rest, &method, None, &mut |_| Ok(()))?;
    println!("{}", motion.message);

    println!("t [s]   tip x [m]   tip z [m]");
    for (t, q) in motion.t.iter().zip(motion.q.chunks_exact(motion.n)).step_by(100) {
        let Vector { x, z, .. } = wire.pose_at(q, &tip).position;
        println!("{t:5.2} {x:11.6} {z:11.6}");
    }
    Ok(())
}
