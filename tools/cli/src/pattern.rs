//! Names of variables chosen by patterns with `*` and `?`.

use describe::preset::nearest;

/// Names and patterns, in the order of the user.
pub struct Patterns<'a>(Vec<&'a str>);

impl<'a> Patterns<'a> {
    /// From arguments, each a name or several separated by commas.
    pub fn new(arguments: &'a [String]) -> Patterns<'a> {
        let parts = arguments.iter().flat_map(|text| text.split(','));
        Patterns(parts.map(str::trim).filter(|p| !p.is_empty()).collect())
    }

    /// Places of the names that match, in the order of the patterns, each once. `why` explains a name that is known and not among them.
    ///
    /// # Errors
    /// A pattern that no name matches, with the nearest name.
    pub fn choose(&self, names: &[&str], why: &dyn Fn(&str) -> Option<String>) -> Result<Vec<usize>, String> {
        if self.0.is_empty() {
            return Err("no name is given".to_owned());
        }
        let mut chosen: Vec<usize> = Vec::new();
        for pattern in &self.0 {
            let found: Vec<usize> = (0..names.len()).filter(|k| matches(pattern, names[*k])).collect();
            if found.is_empty() {
                let unknown = || format!("no variable {pattern}{}", nearest(pattern, names.iter().copied()));
                return Err(why(pattern).unwrap_or_else(unknown));
            }
            let new: Vec<usize> = found.into_iter().filter(|k| !chosen.contains(k)).collect();
            chosen.extend(new);
        }
        Ok(chosen)
    }
}

/// Whether a name matches a pattern: `*` is any text, `?` any character.
fn matches(pattern: &str, name: &str) -> bool {
    let (pattern, name): (Vec<char>, Vec<char>) = (pattern.chars().collect(), name.chars().collect());
    let (mut p, mut n) = (0, 0);
    // Where the last star is, and how far it reaches.
    let mut star: Option<(usize, usize)> = None;
    while n < name.len() {
        match pattern.get(p) {
            Some('*') => {
                star = Some((p, n));
                p += 1;
            }
            Some(c) if *c == '?' || *c == name[n] => (p, n) = (p + 1, n + 1),
            _ => match star {
                Some((at, reach)) => {
                    star = Some((at, reach + 1));
                    (p, n) = (at + 1, reach + 1);
                }
                None => return false,
            },
        }
    }
    pattern[p..].iter().all(|c| *c == '*')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stars_and_question_marks_match() {
        for (pattern, name, yes) in [
            ("thermal.*", "thermal.R_wh", true),
            ("*temperature", "winding_temperature", true),
            ("*temp*ure*", "winding_temperature", true),
            ("?uty", "duty", true),
            ("*", "", true),
            ("duty", "duty_1", false),
            ("*_1", "duty", false),
            ("a*b*c", "aXbXbXc", true),
            ("a*b*c", "aXbXbX", false),
        ] {
            assert_eq!(matches(pattern, name), yes, "{pattern} {name}");
        }
        let arguments = ["current,*temperature".to_owned(), "current".to_owned()];
        let names = ["winding_temperature", "current", "duty"];
        assert_eq!(Patterns::new(&arguments).choose(&names, &|_| None), Ok(vec![1, 0]));
        let error = Patterns::new(&["curent".to_owned()]).choose(&names, &|_| None).unwrap_err();
        assert!(error.contains("curent") && error.contains("did you mean current?"), "{error}");
    }
}
