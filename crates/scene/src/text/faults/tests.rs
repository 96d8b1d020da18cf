//! How many faults a message lists.

use super::*;

#[test]
fn of_many_faults_the_first_are_written_out_and_the_others_counted() {
    let text =
        |bodies: usize| format!("(version: 1, bodies: [{}])", "(mass_kg: -1),".repeat(bodies));
    let message = |bodies| crate::Scene::parse("t", &text(bodies)).unwrap_err().to_string();
    assert_eq!(message(20).lines().count(), 20);
    let many = message(1025);
    assert_eq!((many.lines().count(), many.lines().last()), (21, Some("t: and 1,005 more")));
    assert_eq!([7, 999, 1000, 899_980].map(in_groups), ["7", "999", "1,000", "899,980"]);
}
