//! What the declarations say, as XML, Markdown and checked values.
