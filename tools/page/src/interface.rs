//! What JavaScript calls: it reserves room for a request, writes it, asks for the answer and reads it.

// The names must be exported unmangled; no pointer is dereferenced here.
#![allow(unsafe_code)]

use std::cell::RefCell;

thread_local! {
    static REQUEST: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static ANSWER: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Room for a request of so many bytes of UTF-8; valid until the next call.
#[unsafe(no_mangle)]
extern "C" fn reserve(length: usize) -> *mut u8 {
    REQUEST.with_borrow_mut(|request| {
        request.clear();
        request.resize(length, 0);
        request.as_mut_ptr()
    })
}

/// Answers the request; the number of bytes of the answer.
#[unsafe(no_mangle)]
extern "C" fn answer() -> usize {
    let text = REQUEST.with_borrow(|request| crate::answer(&String::from_utf8_lossy(request)));
    ANSWER.with_borrow_mut(|answer| {
        *answer = text;
        answer.len()
    })
}

/// The answer, UTF-8; valid until the next call.
#[unsafe(no_mangle)]
extern "C" fn text() -> *const u8 {
    ANSWER.with_borrow(|answer| answer.as_ptr())
}
