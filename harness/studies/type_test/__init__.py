"""The type test: comparison of controllers in many stops on which none was tuned, judged by clauses."""
