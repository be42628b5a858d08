use super::*;

#[test]
fn a_path_is_taken_apart_with_its_quotes() {
    assert_eq!(components("/").unwrap(), Vec::<String>::new());
    assert_eq!(components("/'it''s'/'a/b'").unwrap(), ["it's", "a/b"]);
    assert_eq!(components("/'open"), None);
    assert_eq!(components("plain"), None);
    assert_eq!(components("/'a'/'b'/'c'"), None);
}
