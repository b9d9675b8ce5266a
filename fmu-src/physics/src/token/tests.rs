use super::*;
use crate::models::{self, by_token};
use crate::resources::Resources;
use crate::terms::{Driver, Factor, Lag, Port, Product, Table};

fn drop(coefficient: f64) -> GenericTerm {
    let factor = Factor {
        driver: Driver::Speed,
        offset: 0.0,
        reference: 100.0,
        exponent: 1.0,
        range: Factor::UNLIMITED,
    };
    GenericTerm::new(
        Port::TerminalVoltage,
        Law::Product(Product { coefficient, factors: [Some(factor), None, None] }),
    )
}

fn load(angle: Option<f64>) -> LoadTable {
    LoadTable { times: vec![0.0, 0.5], torques: vec![1.0, 2.0], speeds: vec![3.0, 4.0], period: 1.0, angle }
}

/// The contents of archives that all differ.
fn different() -> Vec<Contents> {
    let starts: [&[(u32, f64)]; 5] =
        [&[], &[(100, 0.0)], &[(100, -0.0)], &[(101, 0.0)], &[(100, 0.0), (101, 0.0)]];
    let lagged =
        GenericTerm { lag: Some(Lag { driver: Driver::Speed, tau: 2.0, difference: false }), ..drop(2.0) };
    let slower = GenericTerm { lag: lagged.lag.map(|lag| Lag { tau: 3.0, ..lag }), ..lagged };
    let table = |y: f64| Table::new(Driver::Speed, &[0.0, 1.0], &[0.0, y]).map(Law::Table).unwrap();
    let of = |y: f64| GenericTerm::new(Port::DragTorque, table(y));
    let terms: Vec<Vec<GenericTerm>> = vec![
        vec![],
        vec![drop(2.0)],
        vec![drop(2.5)],
        vec![lagged],
        vec![slower],
        vec![of(1.0)],
        vec![of(2.0)],
        vec![drop(2.0), of(1.0)],
        vec![of(1.0), drop(2.0)],
    ];
    let loads = [None, Some(load(None)), Some(load(Some(0.0))), Some(load(Some(0.5)))];
    let mut all = Vec::new();
    for starts in starts {
        for terms in &terms {
            for load in &loads {
                let resources = Resources { terms: terms.clone(), load: load.clone() };
                all.push(resources.contents(starts.iter().copied()));
            }
        }
    }
    all
}

#[test]
fn archives_with_different_contents_have_different_tokens_of_their_model() {
    let contents = different();
    let mut tokens = Vec::new();
    for kind in models::ALL {
        let own = (kind.declaration)().token;
        for one in &contents {
            let token = own.with(*one);
            let text = token.to_string();
            assert_eq!(Token::parse(&text), Some(token));
            assert_eq!(token.contents(own), *one);
            let found = by_token(&text).map(|kind| (kind.declaration)().name);
            assert_eq!(found, Some((kind.declaration)().name), "{text}");
            tokens.push(text);
        }
    }
    let count = tokens.len();
    tokens.sort_unstable();
    tokens.dedup();
    assert_eq!(tokens.len(), count);
}

#[test]
fn the_bits_of_a_content_are_zero_only_if_it_is_empty() {
    let own = (models::ALL[0].declaration)().token;
    assert_eq!(own.with(Resources::default().contents([])), own);
    let contents = Resources::default().contents([(100, 1.0)]);
    assert!(contents.starts != 0 && (contents.terms, contents.load) == (0, 0), "{contents:?}");
    // Enough terms that some hash has 16 bits that are zero.
    for k in 0..400_000 {
        let contents = Resources::of_terms(&[drop(f64::from(k))]).contents([]);
        assert!(contents.terms != 0 && (contents.starts, contents.load) == (0, 0), "{k}: {contents:?}");
    }
    let resources = Resources { terms: vec![], load: Some(load(None)) };
    let contents = resources.contents([]);
    assert!(contents.load != 0 && (contents.starts, contents.terms) == (0, 0), "{contents:?}");
}

#[test]
fn other_texts_are_no_tokens() {
    let text = (models::ALL[0].declaration)().token.to_string();
    for other in [
        String::new(),
        text.to_uppercase(),
        text.replace('-', ""),
        text.trim_matches(['{', '}']).to_owned(),
        format!("{text}0"),
        format!(" {text}"),
    ] {
        assert_eq!(Token::parse(&other), None, "{other}");
        assert!(by_token(&other).is_none(), "{other}");
    }
}
