//! Home of the tests that need the whole workspace; see the `tests` folder beside this one.
