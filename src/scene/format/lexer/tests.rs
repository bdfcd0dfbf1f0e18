use super::*;
use proptest::prelude::*;

fn tokens(text: &str) -> Result<Vec<Token>, SceneError> {
    let mut stream = TokenStream::new(text.to_string(), "t.pbrt", None);
    std::iter::from_fn(|| stream.next().transpose()).collect()
}

#[test]
fn words_strings_numbers_and_brackets() {
    let kinds: Vec<TokenKind> =
        tokens("# comment\nShape\"a\\\"b\"[-1 .5e1]true").unwrap().into_iter().map(|t| t.kind).collect();
    let number = |value, integer, written: &str| TokenKind::Number { value, integer, written: written.into() };
    assert_eq!(
        kinds,
        [
            TokenKind::Word("Shape".into()),
            TokenKind::Text("a\"b".into()),
            TokenKind::Open,
            number(-1.0, Some(-1), "-1"),
            number(5.0, None, ".5e1"),
            TokenKind::Close,
            TokenKind::Word("true".into()),
        ]
    );
}

#[test]
fn columns_count_characters() {
    let tokens = tokens("\u{feff}Ä \"ö\" x\r\n  y").unwrap();
    let places: Vec<(u32, u32)> = tokens.iter().map(|t| (t.location.line, t.location.column)).collect();
    assert_eq!(places, [(1, 1), (1, 3), (1, 7), (2, 3)]);
}

#[test]
fn lines_end_as_on_any_system() {
    for end in ["\n", "\r\n", "\r"] {
        let text = ["a # b", "# c", "", " d \"e\" [ 1", "2 ] f"].join(end);
        let mut stream = TokenStream::new(text, "t", None);
        let mut places = Vec::new();
        while let Some(token) = stream.next().unwrap() {
            places.push(format!("{}:{} {token}", token.location.line, token.location.column));
            if token.kind == TokenKind::Open {
                let mut held = stream.budget().hold(0).unwrap();
                stream.number_list(|word| word.parse().ok(), &mut Vec::new(), &mut held).unwrap();
            }
        }
        assert_eq!(places, ["1:1 `a`", "4:2 `d`", "4:4 \"e\"", "4:8 `[`", "5:3 `]`", "5:5 `f`"], "{end:?}");
        let error = tokens(&format!("a{end} \"b{end}c\"")).unwrap_err().to_string();
        assert_eq!(error, "t.pbrt:2:2: unterminated string \"b; expected a closing \" on the same line");
    }
}

#[test]
fn number_lists_end_where_a_token_must_tell() {
    let parse = |word: &str| word.parse().ok().filter(|value: &f64| value.is_finite());
    for (text, numbers, next) in [
        (" 1 -2.5\n+3e1 # 4 \u{e4}\n 5]", 4, "3:3 `]`"),
        ("1 2 \u{b2}", 2, "1:5 `\u{b2}`"),
        ("1\"a\"", 1, "1:2 \"a\""),
        ("[1", 0, "1:1 `[`"),
        ("", 0, "the end"),
        ("7 1e999", 1, "1:3: `1e999` is not a finite number"),
        ("7 1.2.3", 1, "1:3: `1.2.3` is not a number"),
    ] {
        let mut stream = TokenStream::new(text.to_string(), "t", None);
        let mut values = Vec::new();
        let mut held = stream.budget().hold(0).unwrap();
        stream.number_list(parse, &mut values, &mut held).unwrap();
        assert_eq!(held.bytes(), 8 * values.len() as u64);
        let then = match stream.next() {
            Ok(Some(token)) => format!("{}:{} {token}", token.location.line, token.location.column),
            Ok(None) => "the end".to_string(),
            Err(error) => error.to_string(),
        };
        assert!(values.len() == numbers && then.contains(next), "{text:?}: {values:?}, then {then}");
    }
}

#[test]
fn bad_text_names_its_place() {
    for (text, expected) in [
        ("a \"b\nc\"", "t.pbrt:1:3: unterminated string"),
        ("a \"b", "t.pbrt:1:3: unterminated string"),
        ("\"\\q\"", "t.pbrt:1:2: unknown escape"),
        (" 1e999", "t.pbrt:1:2: `1e999` is not a finite number"),
        ("1.2.3", "t.pbrt:1:1: `1.2.3` is not a number"),
        ("-inf", "not a finite number"),
    ] {
        let error = tokens(text).unwrap_err().to_string();
        assert!(error.contains(expected), "{text:?}: {error}");
    }
}

proptest! {
    #[test]
    fn never_panics(text in "\\PC{0,200}") {
        let _ = tokens(&text);
    }

    #[test]
    fn numbers_survive(value in proptest::num::f64::NORMAL) {
        let read = tokens(&format!("{value:?}")).unwrap();
        let TokenKind::Number { value: read, .. } = read[0].kind else {
            panic!("not a number");
        };
        prop_assert_eq!(read, value);
    }
}
