//! The FMI 2.0 and 3.0 C interface of the models.
