//! What counts, and what does not.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::*;

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
enum Choice {
    #[default]
    None,
    One(Option<Vec<[u64; 2]>>),
    Two(u64, Vec<u64>),
    Fields {
        list: Vec<u64>,
    },
}

fn read<T: Serialize + for<'de> Deserialize<'de>, const BYTES: usize>(value: &T) -> Option<T> {
    let mut bytes = Vec::new();
    ciborium::into_writer(value, &mut bytes).unwrap();
    let from_cbor = ciborium::from_reader::<AtMost<T, BYTES>, _>(&bytes[..]);
    let json = serde_json::to_vec(value).unwrap();
    let from_json = serde_json::from_slice::<AtMost<T, BYTES>>(&json);
    assert_eq!(from_cbor.is_ok(), from_json.is_ok());
    from_cbor.ok().map(|AtMost(value)| value)
}

#[test]
fn entries_of_lists_and_maps_count_and_fields_do_not() {
    let list = vec![[1_u64, 2], [3, 4]];
    assert_eq!(read::<_, 32>(&list), Some(list.clone()));
    assert_eq!(read::<_, 31>(&list), None);
    // An entry of few bytes in the file is as large as any other one.
    let empty: Vec<Option<[u64; 8]>> = vec![None; 3];
    assert_eq!(read::<_, 216>(&empty), Some(empty.clone()));
    assert_eq!(read::<_, 215>(&empty), None);
    let map = BTreeMap::from([(1_u64, (2_u64, 3_u64)), (4, (5, 6))]);
    assert_eq!(read::<_, 48>(&map), Some(map.clone()));
    assert_eq!(read::<_, 47>(&map), None);
    assert_eq!(read::<_, 0>(&([1.5, 2.5], Some(7_u8), 'x')), Some(([1.5, 2.5], Some(7), 'x')));
}

#[test]
fn lists_count_wherever_they_are() {
    let choices =
        [Choice::One(Some(vec![[1, 2]])), Choice::Two(9, vec![1, 2]), Choice::Fields { list: vec![1, 2] }];
    for choice in choices {
        assert_eq!(read::<_, 16>(&choice), Some(choice.clone()));
        assert_eq!(read::<_, 15>(&choice), None, "{choice:?}");
    }
    let nested = vec![vec![1_u64]; 2];
    assert_eq!(read::<_, { 2 * (24 + 8) }>(&nested), Some(nested.clone()));
    assert_eq!(read::<_, { 2 * (24 + 8) - 1 }>(&nested), None);
}
