//! How a variable is declared: the vocabulary of every table in the project.
