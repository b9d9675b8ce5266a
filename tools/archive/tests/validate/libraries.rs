//! The smallest shared libraries that a reader of symbol tables accepts.

/// A library that defines these names.
pub type Library = fn(&[String]) -> Vec<u8>;

/// For Linux on x86-64.
pub fn linux_x86_64(names: &[String]) -> Vec<u8> {
    elf(62, names)
}

/// For Linux on 64-bit ARM.
pub fn linux_aarch64(names: &[String]) -> Vec<u8> {
    elf(183, names)
}

/// For macOS on x86-64: Mach-O with a symbol table and without a list of exports. Names begin with an underscore there.
pub fn darwin_x86_64(names: &[String]) -> Vec<u8> {
    let (mut strings, mut symbols) = (vec![0_u8], Vec::new());
    for name in names {
        symbols.extend((strings.len() as u32).to_le_bytes());
        // External (1) and defined in a section (0xe), the first; some address.
        symbols.extend([0x0f, 1, 0, 0]);
        symbols.extend(0x1000_u64.to_le_bytes());
        strings.extend(format!("_{name}\0").into_bytes());
    }
    // Magic, x86-64, all subtypes, a dynamic library, one command of 24 bytes; then the command that places both tables.
    let header = [0xfeed_facf_u32, 0x0100_0007, 3, 6, 1, 24, 0, 0];
    let tables_at = 32 + 24;
    let strings_at = tables_at + symbols.len() as u32;
    let command = [2, 24, tables_at, names.len() as u32, strings_at, strings.len() as u32];
    let words = header.iter().chain(&command).flat_map(|word| word.to_le_bytes());
    words.chain(symbols).chain(strings).collect()
}

/// ELF64 with a dynamic symbol table, for the machine of this number.
fn elf(machine: u16, names: &[String]) -> Vec<u8> {
    let mut strings = vec![0_u8];
    let mut symbols = vec![0_u8; 24];
    for name in names {
        symbols.extend((strings.len() as u32).to_le_bytes());
        // Global function in section 1, some address and size.
        symbols.extend([0x12, 0, 1, 0]);
        symbols.extend(0x1000_u64.to_le_bytes());
        symbols.extend(16_u64.to_le_bytes());
        strings.extend(name.as_bytes());
        strings.push(0);
    }
    let symbols_at = 64;
    let strings_at = symbols_at + symbols.len();
    let sections_at = (strings_at + strings.len()).next_multiple_of(8);
    let mut out = b"\x7fELF\x02\x01\x01".to_vec();
    out.resize(16, 0);
    out.extend(3_u16.to_le_bytes());
    out.extend(machine.to_le_bytes());
    out.extend(1_u32.to_le_bytes());
    out.extend([0; 16]);
    out.extend((sections_at as u64).to_le_bytes());
    out.extend([0; 4]);
    for half in [64_u16, 56, 0, 64, 3, 2] {
        out.extend(half.to_le_bytes());
    }
    out.extend(&symbols);
    out.extend(&strings);
    out.resize(sections_at + 64, 0);
    // Sections: null, .dynsym (type 11, strings in section 2), .dynstr (type 3).
    for (kind, at, size, link, info, entry) in
        [(11_u32, symbols_at, symbols.len(), 2_u32, 1_u32, 24_u64), (3, strings_at, strings.len(), 0, 0, 0)]
    {
        out.extend(0_u32.to_le_bytes());
        out.extend(kind.to_le_bytes());
        out.extend([0; 16]);
        out.extend((at as u64).to_le_bytes());
        out.extend((size as u64).to_le_bytes());
        out.extend(link.to_le_bytes());
        out.extend(info.to_le_bytes());
        out.extend(8_u64.to_le_bytes());
        out.extend(entry.to_le_bytes());
    }
    out
}
