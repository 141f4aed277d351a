// A layer's depth word, and its normal in one word.

alias NormalWords = u32;
alias ShapeWords = vec2<u32>;

// The first word and a normal; what the first one is depends on the buffer.
fn shape_words(first: u32, normal: NormalWords) -> ShapeWords {
    return vec2<u32>(first, normal);
}

fn normal_words(words: ShapeWords) -> NormalWords {
    return words.y;
}
