//! Tests of the list. Its effect on light is tested with the integrators.

use super::*;
use crate::{
    Phong,
    test_worlds::{HitFunction, flat_hit},
};
use rt_math::DVec3;

fn materials(priorities: &[i32]) -> Vec<Material> {
    let material = |(i, priority): (usize, &i32)| {
        let interior = InteriorMedium { priority: *priority, ..InteriorMedium::clear(1.0 + i as f64) };
        Material { interior: Some(interior), ..Material::new(format!("{i}"), Phong::default()) }
    };
    priorities.iter().enumerate().map(material).collect()
}

fn hit(object: u32, material: u32) -> SurfaceHit {
    SurfaceHit { object, ..flat_hit(1.0, DVec3::ZERO, DVec3::Y, material) }
}

/// Crosses a surface. Returns the indices of refraction on both sides, or `None` if it is ignored.
fn cross(interior: &mut InteriorList, materials: &[Material], hit: &SurfaceHit, leaving: bool) -> Option<[f64; 2]> {
    let interface = interior.interface(materials, hit.medium_entry(), leaving).expect("room in the list");
    interior.cross(&interface);
    assert_eq!(interior.medium(materials), interface.after);
    interface.is_boundary.then_some([interface.before.ior, interface.after.ior])
}

#[test]
fn the_highest_priority_counts() {
    let materials = materials(&[0, 5, -3]);
    let mut interior = InteriorList::default();
    assert_eq!(cross(&mut interior, &materials, &hit(0, 0), false), Some([1.0, 1.0]));
    assert_eq!(cross(&mut interior, &materials, &hit(1, 1), false), Some([1.0, 2.0]));
    assert_eq!(cross(&mut interior, &materials, &hit(2, 2), false), None);
    assert_eq!(cross(&mut interior, &materials, &hit(0, 0), true), None);
    assert_eq!(cross(&mut interior, &materials, &hit(1, 1), true), Some([2.0, 3.0]));
    assert_eq!(cross(&mut interior, &materials, &hit(2, 2), true), Some([3.0, 1.0]));
    assert!(interior.is_empty());
}

#[test]
fn among_equals_the_dielectric_entered_last_counts() {
    // Objects 0 and 2 are of one material: which of them is left decides whether 1 is there.
    let materials = materials(&[7, 7]);
    for (left, there) in [(0, 1.0), (2, 2.0)] {
        let mut interior = InteriorList::default();
        for (object, material) in [(0, 0), (1, 1), (2, 0)] {
            assert!(cross(&mut interior, &materials, &hit(object, material), false).is_some());
        }
        cross(&mut interior, &materials, &hit(left, 0), true);
        assert_eq!(interior.medium(&materials).ior, there, "after leaving {left}");
    }
}

#[test]
fn what_is_left_without_having_been_entered_lay_below_all_else() {
    let materials = materials(&[0, 0, 1]);
    let mut interior = InteriorList::default();
    cross(&mut interior, &materials, &hit(1, 1), false);
    assert_eq!(cross(&mut interior, &materials, &hit(0, 0), true), None, "covered by an equal that was entered");
    assert_eq!(cross(&mut interior, &materials, &hit(2, 2), true), Some([3.0, 2.0]), "of higher priority");
    assert_eq!(interior.entries, [MediumEntry { object: 1, material: 1 }]);
}

#[test]
fn a_full_list_refuses_more() {
    let materials = materials(&[0, 0]);
    let mut interior = InteriorList::default();
    for object in 0..MAX_DIELECTRICS as u32 {
        cross(&mut interior, &materials, &hit(object, 0), false);
    }
    assert!(interior.interface(&materials, hit(99, 0).medium_entry(), false).is_none());
    assert!(interior.interface(&materials, hit(99, 1).medium_entry(), true).is_none(), "nor can it be noted as around");
    assert!(interior.interface(&materials, hit(99, 0).medium_entry(), true).is_some());
}

#[test]
fn lists_of_streams_are_read_as_they_were_added() {
    let materials = materials(&[0, 1]);
    let mut lists = InteriorLists::default();
    let mut interior = InteriorList::filled_with(0);
    let entering = interior.interface(&materials, hit(4, 1).medium_entry(), false).expect("room");
    let leaving = interior.interface(&materials, hit(7, 0).medium_entry(), true).expect("it is there");
    let around = lists.push(&interior);
    let within = lists.push_behind(&interior, entering.event);
    let outside = lists.push_behind(&interior, leaving.event);
    assert_eq!((outside, lists.len()), (ListRange::default(), 3));
    let unchanged = lists.push_changed(&interior, around);
    assert_eq!((unchanged, lists.len()), (around, 3));

    let two = [InteriorList::filled_with(0).entries[0], MediumEntry { object: 4, material: 1 }];
    for (range, expected) in [(within, &two[..]), (outside, &[]), (around, &two[..1])] {
        lists.read(range, &mut interior);
        assert_eq!(interior.entries, expected);
    }
    let noted = interior.interface(&materials, hit(8, 1).medium_entry(), true).expect("noted as around");
    let changed = lists.push_changed(&interior, around);
    lists.read(changed, &mut interior);
    assert_eq!(interior.entries, [MediumEntry { object: 8, material: 1 }, two[0]]);
    let behind = lists.push_behind(&interior, noted.event);
    lists.read(behind, &mut interior);
    assert_eq!(interior.entries, [two[0]]);
    let mut ranges = [ListRange::default(), changed, around];
    lists.keep_only(1, ranges.iter_mut());
    assert_eq!((ranges[0], ranges[2], lists.len()), (ListRange::default(), around, 3));
    lists.read(ranges[1], &mut interior);
    assert_eq!(interior.entries, [MediumEntry { object: 8, material: 1 }, two[0]]);
    lists.truncate(1);
    assert_eq!(lists.len(), 1);
}

#[test]
fn looking_around_finds_the_dielectrics_of_the_origin_in_their_order() {
    // From inside of 0 and 1, through a dielectric 2 that is entered and left on the way, and an opaque one that is not
    // there.
    let surfaces = [(1, 1, true), (2, 2, false), (9, 77, false), (2, 2, true), (0, 0, true)];
    let mut way = HitFunction(|ray: &Ray, span: Interval| {
        let at = if span.min > 0.0 { span.min as usize } else { 0 };
        let &(object, material, leaving) = surfaces.get(at)?;
        let mut met = SurfaceHit { t: (at + 1) as f64, ..hit(object, material) };
        met.interaction.geometric_normal = if leaving { ray.direction } else { -ray.direction };
        Some(met)
    });
    let materials = materials(&[0, 0, 0]);
    let mut interior = InteriorList::filled_with(2);
    interior.find_enclosing_media(&mut way, &materials, &Ray::new(DVec3::ZERO, DVec3::Z));
    assert_eq!(interior.entries, [MediumEntry { object: 0, material: 0 }, MediumEntry { object: 1, material: 1 }]);
    assert_eq!(interior.medium(&materials).ior, 2.0, "the innermost was entered last");
    interior.clear();
    assert!(interior.is_empty());
}

#[test]
fn inlined_interfaces_are_those_of_any_list() {
    let materials = materials(&[0, 5, 0]);
    let all = [(0, 0), (1, 0), (2, 1), (3, 2)].map(|(object, material)| MediumEntry { object, material });
    let lists = [&all[..0], &all[..1], &all[1..2], &all[2..3], &all[..2], &all[1..]];
    for (entries, entry, leaving) in
        lists.iter().flat_map(|list| all.map(|entry| [(list, entry, false), (list, entry, true)])).flatten()
    {
        let [mut inlined, mut any] = [(); 2].map(|()| InteriorList { entries: entries.to_vec() });
        let case = format!("{entry:?} in {entries:?}, leaving: {leaving}");
        let found = format!("{:?}", inlined.interface(&materials, entry, leaving));
        assert_eq!(found, format!("{:?}", any.nested_interface(&materials, entry, leaving)), "{case}");
        assert_eq!(inlined, any, "{case}");
        let event = inlined.interface(&materials, entry, leaving).expect("room in the list").event;
        assert_eq!(format!("{:?}", inlined.event(entry, leaving)), format!("Some({event:?})"), "{case}");
    }
}
