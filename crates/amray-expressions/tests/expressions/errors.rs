//! What is no expression: messages that name the place, and no text that makes the reader panic or hang.

use crate::program;
use amray_expressions::Expression;
use proptest::prelude::*;

#[test]
fn errors_name_the_place() {
    for (text, expected) in [
        ("", "column 1: expected a number, a name or a parenthesis"),
        ("sqrt(a", "column 7: expected ')'"),
        ("a b", "column 3: found 'b', expected an operator or the end"),
        ("a +", "column 4: expected a number, a name or a parenthesis"),
        ("a + ) b", "column 5: found ')', expected a number, a name or a parenthesis"),
        ("2e", "column 2: found 'e', expected an operator or the end"),
        (".", "column 1: found '.', expected a number"),
        ("a = b", "column 3: found '=', expected an operator or the end"),
        ("<a", "column 1: a name that starts with < and has no end, expected >"),
        ("1 + 2 * densty", "column 9: no field \"densty\""),
        ("ä + ö", "column 5: no field \"ö\""),
        ("sin()", "column 1: sin of nothing, expected a number"),
        ("sin(a, a)", "column 1: sin of a number and a number, expected a number"),
        ("min(a)", "column 1: min of a number, expected two or more numbers"),
        ("{a, 1}", "column 1: a vector of 2 components, expected 3"),
        ("{a, a, {a, a, a}}", "column 1: a vector of vectors, expected one of numbers"),
        ("sin({a, a, a})", "column 1: sin of a vector, expected a number"),
        ("a[0]", "column 2: a number has no components, expected a vector before ["),
        ("{a, a, a}[3]", "column 11: found '3', expected 0, 1 or 2"),
        ("divergence(a)", "column 1: divergence of a number, expected a vector or its three components"),
        (
            "{a,a,a} * {a,a,a}",
            "column 9: * of a vector and a vector, expected numbers, or a number and a vector (dot and cross multiply vectors)",
        ),
        ("{a,a,a} < 1", "column 9: < of a vector and a number, expected two numbers"),
    ] {
        let error = program(text, &["a", "ä"], &[]).unwrap_err().to_string();
        assert_eq!(error, expected, "{text}");
    }
    let error = program("sqr(a)", &["a"], &[]).unwrap_err().to_string();
    assert!(error.starts_with("column 1: no function \"sqr\"; the functions are abs, sqrt, exp, "), "{error}");
}

#[test]
fn long_and_deep_texts_are_refused_at_once() {
    for part in ["(", "-", "sin(", "{", "2^", "if(", "a+", "<", "a[", "+", "1e", "a<", "((a)", "𝄞"] {
        for length in [50, 150, 4000, 1 << 20] {
            let text: String = part.repeat(length / part.len());
            if let Ok(expression) = Expression::parse(&text) {
                panic!("{part} repeated is {expression:?}");
            }
        }
    }
    let nested = |depth: usize| format!("{}a{}", "(".repeat(depth), ")".repeat(depth));
    assert!(Expression::parse(&nested(90)).is_ok());
    assert_eq!(Expression::parse(&nested(101)).unwrap_err().to_string(), "column 101: parts nest deeper than 100");
    assert!(Expression::parse(&nested(1 << 19)).unwrap_err().to_string().contains("expected at most 4096"));
    // A long sum is not deep.
    assert!(program(&("a+".repeat(2000) + "a"), &["a"], &[]).is_ok());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn any_text_is_an_expression_or_an_error(text in "\\PC{0,40}") {
        _ = program(&text, &["a", "b"], &[]);
    }

    #[test]
    fn any_tokens_are_an_expression_or_an_error(tokens in prop::collection::vec(
        prop::sample::select(vec![
            "a", "b", "x", "1", "2.5e3", "<", ">", "<a>", "<=", "==", "+", "-", "*", "/", "^", "**", "(", ")", "{", "}",
            "[", "]", "0", ",", "sin(", "if(", "dot(", "gradient(", "divergence(", "min(", " ", "magnitude(",
        ]),
        0..40,
    )) {
        _ = program(&tokens.concat(), &["a", "b"], &[]);
    }
}
