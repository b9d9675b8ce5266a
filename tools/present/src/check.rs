//! Rules for every page, for the tests of the crates that write pages.

use roxmltree::{Document, Node};

/// First words of a question; headings are noun phrases.
const QUESTIONS: [&str; 8] = ["What", "How", "Why", "Where", "Whether", "Which", "Who", "When"];

/// Rules that a page breaks, one sentence each.
pub fn faults(page: &str) -> Vec<String> {
    let mut faults = Vec::new();
    for (rule, needed) in [
        ("no viewport", "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"),
        ("no dark scheme", "@media (prefers-color-scheme:dark){:root{"),
        ("no rules for paper", "@media print"),
    ] {
        if !page.contains(needed) {
            faults.push(rule.to_owned());
        }
    }
    for outside in ["src=", "href=\"http", "@import", "url("] {
        // matplotlib refers to parts of its own picture by url(#...).
        if page.replace("url(#", "").contains(outside) {
            faults.push(format!("{outside} needs a network"));
        }
    }
    let body = page.find("<body").and_then(|from| Some(&page[from..page.find("</body>")? + 7]));
    // xlink is declared by matplotlib's own root element only.
    match body.map(Document::parse) {
        None => faults.push("no body".to_owned()),
        Some(Err(error)) => faults.push(format!("body: {error}")),
        Some(Ok(document)) => {
            document.descendants().filter(Node::is_element).for_each(|n| faults.extend(of_element(n)));
        }
    }
    faults
}

/// The texts of a page without what is code: a name in them is a word.
pub fn texts(page: &str) -> Vec<String> {
    let body = page.find("<body").and_then(|from| Some(&page[from..page.find("</body>")? + 7]));
    let Some(Ok(document)) = body.map(Document::parse) else { return Vec::new() };
    let is_word = |n: &Node| n.is_text() && !inside(*n, "code") && !inside(*n, "style");
    document.descendants().filter(is_word).filter_map(|n| n.text().map(str::to_owned)).collect()
}

fn inside(node: Node, tag: &str) -> bool {
    node.ancestors().any(|a| a.has_tag_name(tag) || a.tag_name().name() == tag)
}

fn of_element(node: Node) -> Vec<String> {
    let mut faults = Vec::new();
    let name = node.tag_name().name();
    let all: String = node.descendants().filter_map(|n| n.is_text().then(|| n.text()).flatten()).collect();
    let begin = || all.chars().take(60).collect::<String>();
    match name {
        "table" => {
            if node.parent().is_none_or(|p| p.attribute("class") != Some("wide")) {
                faults.push(format!("table without a container that scrolls: {}", begin()));
            }
            let rows = || node.descendants().filter(|n| n.tag_name().name() == "tr");
            let count = |row: Node| row.children().filter(Node::is_element).count();
            let columns = rows().next().map_or(0, count);
            if rows().any(|row| count(row) != columns) {
                faults.push(format!("table with rows of several lengths: {}", begin()));
            }
        }
        "svg"
            if node.attribute("aria-label").is_none() && node.attribute("role") == Some("img")
                || !node.ancestors().any(|a| a.children().any(|c| c.has_tag_name("figcaption"))) =>
        {
            faults.push("svg without a label or a caption".to_owned());
        }
        "h1" | "h2" | "h3" => {
            let first = all.split(' ').next().unwrap_or_default();
            if all.is_empty() || QUESTIONS.contains(&first) || all.ends_with(['.', '?', '!']) {
                faults.push(format!("heading that is no noun phrase: {all:?}"));
            }
        }
        _ => {}
    }
    let written =
        inside(node, "code") || inside(node, "pre") || inside(node, "style") || inside(node, "script");
    if written || inside(node, "metadata") {
        return faults;
    }
    let text: String = node.children().filter_map(|n| n.is_text().then(|| n.text()).flatten()).collect();
    // The first cell of a row is its label.
    let is_label = ["h1", "h2", "h3", "th", "summary", "figcaption", "text", "option", "label"]
        .contains(&name)
        || name == "td" && node.prev_sibling_element().is_none();
    if is_label && let Some(key) = text.split_whitespace().find(|word| is_key(word)) {
        faults.push(format!("raw key as a label: {key} in {:?}", begin()));
    }
    if let Some(word) = text.split_whitespace().find(|word| has_long_fraction(word)) {
        faults.push(format!("number with too many digits: {word}"));
    }
    if text.contains("NaN") {
        faults.push(format!("no number: {text:?}"));
    }
    faults
}

/// Whether a word is a name as programs write it, with at least two letters on both sides of an underscore. T_w and R_ha are symbols, and the structured
/// name of a variable (motor.R_ref, effect.iron_loss.k) is its only name.
pub fn is_key(word: &str) -> bool {
    let is_letter = |c: Option<char>| c.is_some_and(|c| c.is_ascii_alphabetic());
    if word
        .match_indices('.')
        .any(|(at, _)| is_letter(word[..at].chars().next_back()) && is_letter(word[at + 1..].chars().next()))
    {
        return false;
    }
    let long = |part: &str| part.chars().take_while(|c| c.is_ascii_alphabetic()).count() >= 2;
    word.match_indices('_').any(|(at, _)| {
        let before: String = word[..at].chars().rev().collect();
        long(&before) && long(&word[at + 1..])
    })
}

/// More than six significant digits after a point.
fn has_long_fraction(word: &str) -> bool {
    let digits = |part: &str| part.trim_start_matches('0').chars().take_while(char::is_ascii_digit).count();
    word.split('.').skip(1).any(|part| digits(part) > 6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::page;
    use maud::{PreEscaped, html};

    #[test]
    fn every_rule_finds_its_fault() {
        for (body, fault) in [
            ("<table><tr><td>1</td></tr></table>", "without a container"),
            (
                "<div class=\"wide\"><table><tr><th>a</th><th>b</th></tr><tr><td>1</td></tr></table></div>",
                "several lengths",
            ),
            ("<figure><svg/></figure>", "caption"),
            ("<h2>What is said</h2>", "noun phrase"),
            ("<h2>current_rms</h2>", "raw key"),
            (
                "<div class=\"wide\"><table><tr><td>current_rms_A</td><td>by cooling_mode</td></tr></table></div>",
                "raw key",
            ),
            (
                "<figure><svg aria-label=\"a\"><text>shaft_torque, N.m</text></svg><figcaption>c</figcaption></figure>",
                "raw key",
            ),
            ("<p>1.23456789 K</p>", "too many digits"),
            ("<p>NaN</p>", "no number"),
            ("<img src=\"x.png\"/>", "network"),
            ("<p>", "body:"),
        ] {
            let found = faults(&page("Title", html! { (PreEscaped(body)) }));
            assert!(found.len() == 1 && found[0].contains(fault), "{fault}: {found:?}");
        }
        let fine = "<h2>Winding R_ha of <code>motor.k_t</code></h2><p>fan_command, 0.3865, 0.0009822</p><h3>effect.iron_loss.k</h3>";
        assert_eq!(faults(&page("Title", html! { (PreEscaped(fine)) })), Vec::<String>::new());
        assert_eq!(
            texts(&page("Title", html! { (PreEscaped(fine)) }))[..3],
            ["Title", "Winding R_ha of ", "fan_command, 0.3865, 0.0009822"]
        );
        assert_eq!(faults("<html></html>").len(), 4);
    }
}
