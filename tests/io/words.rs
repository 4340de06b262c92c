//! What the system refused, in words for a person.

use burin::io::{in_words, without_numbers};
use std::io::{Error, ErrorKind};

#[test]
fn no_reason_has_the_systems_numbers() {
    for code in 1..134 {
        let said = in_words(&Error::from_raw_os_error(code));
        assert!(!said.is_empty() && !said.contains("os error"), "{code}: {said}");
    }
    assert_eq!(in_words(&ErrorKind::StorageFull.into()), "the disk is full");
    assert_eq!(in_words(&ErrorKind::NotFound.into()), "it is not there");
    // A sentence of this program's own says more than its kind.
    let own = Error::new(ErrorKind::IsADirectory, "there is a folder of that name");
    assert_eq!(in_words(&own), "there is a folder of that name");
}

#[test]
fn numbers_are_taken_out_of_a_sentence_and_nothing_else() {
    for (text, plain) in [
        ("a: No such file or directory (os error 2)", "a: No such file or directory"),
        ("a (os error 2); b (os error -17)!", "a; b!"),
        ("a (os error two)", "a (os error two)"),
        ("(os error 2)", "(os error 2)"),
        ("a (os error 2", "a (os error 2"),
        ("", ""),
    ] {
        assert_eq!(without_numbers(text), plain);
    }
}

#[test]
fn a_file_that_is_not_there_is_told_in_words() {
    let error = burin::io::open("/nowhere/at/all.nii").unwrap_err().to_string();
    assert!(error.contains("/nowhere/at/all.nii") && error.contains("it is not there"), "{error}");
    assert!(!error.contains("os error"), "{error}");
}
